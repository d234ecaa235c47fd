"""What the site has beside the pages: parameters from their table; links out of it as names."""

import re

from mkdocs.structure.files import File

from peg_on_hole_ros.config.parameter_table import PARAMETERS

# A link that leaves the docs: the site has no page for it, a checkout has the file.
_OUTSIDE = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+)([^)#\s]+)(#[^)]*)?\)")
_HEAD = """# Parameters

Node and command line take the same, as a ROS 2 parameters file. `config/peg_on_hole.yaml` has all
of them with their defaults.
*Live* ones can be set while the node runs.
"""


def on_files(files, config):
    """Add the page of the parameters."""
    files.append(File.generated(config, "parameters.md", content=parameters()))
    return files


def on_page_markdown(markdown, page, config, files):
    """Turn links to files outside of the docs into their names."""
    depth = page.file.src_uri.count("/")

    def named(match):
        ups = match[2].count("../")
        return (
            f"{match[1]} (`{match[3]}`)"
            if ups > depth and match[3] not in match[1]
            else (match[1] if ups > depth else match[0])
        )

    return _OUTSIDE.sub(named, markdown)


def parameters() -> str:
    """Return the page of all parameters, a table for each group."""
    groups: dict[str, list[str]] = {}
    for row in PARAMETERS:
        group = row.name.rpartition(".")[0] or "node"
        cells = (f"`{row.name}`", _default(row.default), row.unit, _range(row), _effect(row))
        groups.setdefault(group, []).append("| " + " | ".join(map(_cell, cells)) + " |")
    parts = [_HEAD]
    for group, lines in groups.items():
        parts.append(
            f"## {group}\n\n| name | default | unit | range | effect |\n|---|---|---|---|---|"
        )
        parts[-1] += "\n" + "\n".join(lines)
    return "\n\n".join(parts) + "\n"


def _cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def _default(value):
    if isinstance(value, tuple):
        return "`[" + ", ".join(map(str, value)) + "]`"
    return f"`{str(value).lower() if isinstance(value, bool) else value}`" if value != "" else ""


def _range(row):
    if row.choices:
        return ", ".join(f"`{choice}`" for choice in row.choices)
    if row.low is None and row.high is None:
        return ""
    low = "" if row.low is None else f"{row.low:g}"
    high = "" if row.high is None else f"{row.high:g}"
    return f"{low} to {high}".strip()


def _effect(row):
    return row.effect + (" *Live.*" if row.live else "")
