"""Schemas of Foxglove's messages in half the room: a recording holds each of them twice, once not compressed."""

from foxglove import Schema
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet


def compact(schema: Schema) -> Schema:
    """The same messages and fields, described in one file a package, without what only generators of code read."""
    packages: dict[str, FileDescriptorProto] = {}
    package_of: dict[str, str] = {}  # by file
    for file in FileDescriptorSet.FromString(schema.data).file:
        package_of[file.name] = file.package
        whole = packages.setdefault(
            file.package, FileDescriptorProto(name=file.package, package=file.package, syntax=file.syntax)
        )
        for message in file.message_type:
            whole.message_type.append(_bare(message, f".{file.package}."))
        whole.enum_type.extend(file.enum_type)
        needed = {package_of[name] for name in file.dependency} - {file.package, *whole.dependency}
        whole.dependency.extend(sorted(needed))
    # google.protobuf, which needs nothing, comes before foxglove, which needs it.
    files = sorted(packages.values(), key=lambda file: len(file.dependency))
    return Schema(name=schema.name, encoding=schema.encoding, data=FileDescriptorSet(file=files).SerializeToString())


def _bare(message: DescriptorProto, package: str) -> DescriptorProto:
    """Without what follows from the rest.

    That is a field's name in JSON, that it is optional, and the package before the types of the same package: a name
    that does not begin with a dot is looked for from the inside out (descriptor.proto, `type_name`).
    """
    for field in message.field:
        field.ClearField("json_name")
        if field.label == FieldDescriptorProto.LABEL_OPTIONAL:
            field.ClearField("label")
        if field.type_name.startswith(package):
            field.type_name = field.type_name.removeprefix(package)
    for nested in message.nested_type:
        _bare(nested, package)
    return message
