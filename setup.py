"""Installs the package with pip or colcon; the extras are what pip adds where no ROS is."""

from glob import glob

from setuptools import find_packages, setup

NAME = "peg_on_hole_ros"
SHARE = f"share/{NAME}"

# ROS 2 Kilted as wheels (x86_64, CPython 3.10 to 3.13), for machines without a native ROS.
ROS = [
    "ros-kilted-rclpy==9.1.2",
    "ros-kilted-rmw-fastrtps-cpp==9.3.3",
    "ros-kilted-std-msgs==5.5.1",
    "ros-kilted-geometry-msgs==5.5.1",
    "ros-kilted-sensor-msgs==5.5.1",
    "ros-kilted-diagnostic-msgs==5.5.1",
    "ros-kilted-visualization-msgs==5.5.1",
    "ros-kilted-std-srvs==5.5.1",
]

# colcon's Python build calls `setup.py install`, which newer setuptools no longer has.
COLCON = [
    "colcon-core==0.21.3",
    "colcon-ros==0.5.0",
    "colcon-bash==0.5.0",
    "colcon-output==0.2.15",
    "colcon-test-result==0.3.8",
    "setuptools<80",
]

TESTS = [
    # What the estimator is held against.
    "filterpy>=1.4.5",
    "hypothesis>=6.100",
    # With 9.2 the groups of pytest-xdist 3.8 have no effect, and no word of it.
    "pytest>=8,<9.2",
    "pytest-timeout>=2.3",
    "pytest-xdist>=3.6",
]

CHECKS = [
    "import-linter>=2.1",
    "mpmath>=1.3",
    # With another release other remarks are needed, as with ruff.
    "mypy==2.4.1",
    # Drives the browser that the machine has; it brings none.
    "playwright>=1.45",
    "ruff==0.17.5",
    "sympy>=1.12",
]

setup(
    name=NAME,
    version="0.1.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={"": ["*.xml"], NAME: ["py.typed"], f"{NAME}.report": ["page/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (SHARE, ["package.xml"]),
        (f"{SHARE}/config", sorted(glob("config/*.*"))),
        (f"{SHARE}/launch", sorted(glob("launch/*.launch.py"))),
    ],
    python_requires=">=3.10",
    install_requires=[
        "lz4>=4.0",
        "mcap>=1.6",
        "mcap-ros2-support>=0.6",
        "numba>=0.58",
        "numpy>=1.25",
        "pyyaml>=6",
        "rich>=13",
        # Bags in SQLite.
        "rosbags>=0.11",
        "scipy>=1.10",
        "zstandard>=0.20",
    ],
    extras_require={
        "ros": ROS,
        "report": ["matplotlib>=3.7", "plotly>=6.0"],
        "urdf": ["pin==4.1.0"],
        "watch": ["websockets>=13.1"],
        "foxglove": ["foxglove-sdk>=0.27"],
        "parquet": ["pyarrow>=14"],
        "cluster": ["distributed>=2023.12"],
        "docs": ["mkdocs>=1.6", "mkdocs-material>=9.5", "mkdocstrings[python]>=0.26"],
        # For a run of tests of node and command line; "dev" has what all others need.
        "test": TESTS,
        "dev": COLCON + TESTS + CHECKS,
    },
    zip_safe=False,
    author="peg_on_hole developers",
    author_email="dev@example.org",
    maintainer="peg_on_hole developers",
    maintainer_email="dev@example.org",
    description="Contact-state estimation for a cylindrical peg being set on a hole.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "peg-on-hole = peg_on_hole_ros.cli.main:main",
            "peg_on_hole = peg_on_hole_ros.ros.node:main",
        ],
    },
)
