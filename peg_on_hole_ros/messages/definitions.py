"""Definitions of the ROS 2 messages that a bag of this package carries, as bags hold them."""

# Fields and constants of common_interfaces and rcl_interfaces (Apache-2.0), without comments.
_DEFINITIONS = {
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "diagnostic_msgs/DiagnosticArray": """\
std_msgs/Header header
DiagnosticStatus[] status""",
    "diagnostic_msgs/DiagnosticStatus": """\
byte OK=0
byte WARN=1
byte ERROR=2
byte STALE=3
byte level
string name
string message
string hardware_id
KeyValue[] values""",
    "diagnostic_msgs/KeyValue": """\
string key
string value""",
    "geometry_msgs/Point": """\
float64 x
float64 y
float64 z""",
    "geometry_msgs/Pose": """\
Point position
Quaternion orientation""",
    "geometry_msgs/PoseWithCovariance": """\
Pose pose
float64[36] covariance""",
    "geometry_msgs/PoseWithCovarianceStamped": """\
std_msgs/Header header
PoseWithCovariance pose""",
    "geometry_msgs/Quaternion": """\
float64 x 0
float64 y 0
float64 z 0
float64 w 1""",
    "geometry_msgs/Transform": """\
Vector3 translation
Quaternion rotation""",
    "geometry_msgs/TransformStamped": """\
std_msgs/Header header
string child_frame_id
Transform transform""",
    "geometry_msgs/Vector3": """\
float64 x
float64 y
float64 z""",
    "geometry_msgs/Wrench": """\
Vector3 force
Vector3 torque""",
    "geometry_msgs/WrenchStamped": """\
std_msgs/Header header
Wrench wrench""",
    "sensor_msgs/CompressedImage": """\
std_msgs/Header header
string format
uint8[] data""",
    "sensor_msgs/JointState": """\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort""",
    "std_msgs/Bool": """\
bool data""",
    "std_msgs/ColorRGBA": """\
float32 r
float32 g
float32 b
float32 a""",
    "std_msgs/Header": """\
builtin_interfaces/Time stamp
string frame_id""",
    "std_msgs/String": """\
string data""",
    "std_msgs/UInt8": """\
uint8 data""",
    "tf2_msgs/TFMessage": """\
geometry_msgs/TransformStamped[] transforms""",
    "visualization_msgs/Marker": """\
int32 ARROW=0
int32 CUBE=1
int32 SPHERE=2
int32 CYLINDER=3
int32 LINE_STRIP=4
int32 LINE_LIST=5
int32 CUBE_LIST=6
int32 SPHERE_LIST=7
int32 POINTS=8
int32 TEXT_VIEW_FACING=9
int32 MESH_RESOURCE=10
int32 TRIANGLE_LIST=11
int32 ARROW_STRIP=12
int32 ADD=0
int32 MODIFY=0
int32 DELETE=2
int32 DELETEALL=3
std_msgs/Header header
string ns
int32 id
int32 type
int32 action
geometry_msgs/Pose pose
geometry_msgs/Vector3 scale
std_msgs/ColorRGBA color
builtin_interfaces/Duration lifetime
bool frame_locked
geometry_msgs/Point[] points
std_msgs/ColorRGBA[] colors
string texture_resource
sensor_msgs/CompressedImage texture
UVCoordinate[] uv_coordinates
string text
string mesh_resource
MeshFile mesh_file
bool mesh_use_embedded_materials""",
    "visualization_msgs/MarkerArray": """\
Marker[] markers""",
    "visualization_msgs/MeshFile": """\
string filename
uint8[] data""",
    "visualization_msgs/UVCoordinate": """\
float32 u
float32 v""",
}

_PRIMITIVES_USED = {"bool", "byte", "float32", "float64", "int32", "string", "uint8", "uint32"}


def definition(ros_type: str) -> str:
    """
    Return the definition of a message and of all that it contains, concatenated as in MCAP.

    Parameters
    ----------
    ros_type : str
        As in `geometry_msgs/msg/WrenchStamped`.

    Raises
    ------
    KeyError
        A type that no topic of this package has.

    """
    name = ros_type.replace("/msg/", "/")
    parts, queue = [], [name]
    for current in queue:
        text = _DEFINITIONS[current]
        head = f"{'=' * 80}\nMSG: {current}\n" if parts else ""
        parts.append(head + text)
        queue += [other for other in _contained(current) if other not in queue]
    return "\n".join(parts) + "\n"


def fields(name: str) -> list[tuple[str, str, str | None]]:
    """
    Return type, name and default of each field of a message, constants left out.

    Parameters
    ----------
    name : str
        As in `sensor_msgs/JointState`; types of messages are returned in the same form, arrays
        with their brackets.

    """
    found = []
    for line in _DEFINITIONS[name].splitlines():
        kind, field, *default = line.split()
        if "=" not in line:
            base, bracket, length = kind.partition("[")
            if base not in _PRIMITIVES_USED and "/" not in base:
                base = f"{name.split('/')[0]}/{base}"
            found.append((base + bracket + length, field, default[0] if default else None))
    return found


def _contained(name):
    for kind, _, _ in fields(name):
        base = kind.split("[")[0]
        if base not in _PRIMITIVES_USED:
            yield base
