"""glTF 2.0 files: `description.read_gltf` turns one into the dictionary that Mitsuba's parser takes.

From the bytes up: `document` (container and JSON) with its `schema` and `references`, `buffers` (and
`uris`, `meshopt`), `accessors`, `draco`; then what they describe: `nodes`, `primitives`, `deform`,
`images`, `textures`, `materials`, `lights`, `cameras`, `instancing`; and `structure`, what moves.
"""
