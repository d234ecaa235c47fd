"""The part of JSON Schema that the schemas of this package use; unknown keywords are an error."""

_TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "integer": int,
    "number": (int, float),
    "null": type(None),
}
_NOTES = {"$schema", "$id", "$defs", "title", "description"}
_KNOWN = {
    "type", "const", "enum", "minimum", "maximum", "required", "properties", "items",
    "additionalProperties", "$ref",
}  # fmt: skip


def check(value, schema, root=None, path="$"):
    """Raise AssertionError with the path where a value does not fit."""
    root = root or schema
    assert not set(schema) - _NOTES - _KNOWN, f"{path}: unknown keywords in {schema}"
    if "$ref" in schema:
        target = root
        for part in schema["$ref"].removeprefix("#/").split("/"):
            target = target[part]
        check(value, target, root, path)
    if "type" in schema:
        names = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
        fits = any(isinstance(value, _TYPES[name]) for name in names)
        assert fits and not isinstance(value, bool), f"{path}: {value!r} is not {names}"
    if "const" in schema:
        assert value == schema["const"], f"{path}: {value!r} is not {schema['const']!r}"
    if "enum" in schema:
        assert value in schema["enum"], f"{path}: {value!r} is not in {schema['enum']}"
    if isinstance(value, (int, float)):
        assert value >= schema.get("minimum", value), f"{path}: {value} is too small"
        assert value <= schema.get("maximum", value), f"{path}: {value} is too large"
    if isinstance(value, list) and "items" in schema:
        for i, item in enumerate(value):
            check(item, schema["items"], root, f"{path}[{i}]")
    if isinstance(value, dict):
        _check_object(value, schema, root, path)


def _check_object(value, schema, root, path):
    for name in schema.get("required", ()):
        assert name in value, f"{path}: {name} is missing"
    rest = schema.get("additionalProperties", True)
    for name, item in value.items():
        if name in schema.get("properties", {}):
            check(item, schema["properties"][name], root, f"{path}.{name}")
        else:
            assert rest is not False, f"{path}: {name} is not in the schema"
            if isinstance(rest, dict):
                check(item, rest, root, f"{path}.{name}")
