"""Schemas of Foxglove's messages in half the room: a recording holds each of them twice, once not compressed."""

from foxglove import Schema
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet


def compact(schema: Schema) -> Schema:
    """The same messages and fields, described in one file a package, without what only generators of code read."""
    packages: dict[str, FileDescriptorProto] = {}
    package_of: dict[str, str] = {}  # by file
    for file in FileDescriptorSet.FromString(schema.data).file:
        package_of[file.name] = file.package
        whole = packages.setdefault(
            file.package, FileDescriptorProto(name=file.package, package=file.package, syntax=file.syntax)
        )
        whole.message_type.extend(file.message_type)
        whole.enum_type.extend(file.enum_type)
        needed = {package_of[name] for name in file.dependency} - {file.package, *whole.dependency}
        whole.dependency.extend(sorted(needed))
    # google.protobuf, which needs nothing, comes before foxglove, which needs it.
    files = sorted(packages.values(), key=lambda file: len(file.dependency))
    return Schema(name=schema.name, encoding=schema.encoding, data=FileDescriptorSet(file=files).SerializeToString())
