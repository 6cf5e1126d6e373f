"""glTF 2.0 files: `description.read_gltf` turns one into the dictionary that Mitsuba's parser takes.

From the bytes up: `document` (container and JSON) with its `schema` and `references`; `buffers`, with
`uris` and `meshopt`; `accessors`; `draco`. Then what they describe: `nodes`; `primitives`, which
`deform` bends and `placement` puts in place, to `shapes`, `instancing` and `names` among them;
`images`, `textures`, `materials`; `lights`; `cameras`; and `motion`, which nothing here plays.
"""
