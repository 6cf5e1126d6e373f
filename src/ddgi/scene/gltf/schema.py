"""The shape of a glTF 2.0 document's JSON: what must be there, of which type, within which range.

After the JSON schemas of the glTF 2.0 specification and of the extensions named. Fields that nothing
here reads are ignored, whatever they hold.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Le, Len, MinLen
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field
from pydantic.alias_generators import to_camel


def _whole(value: Any) -> Any:
    """JSON has one kind of number: 3.0 is an integer too (section 2.7 of the specification)."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _printable(text: str) -> str:
    """Names end up in messages of one line."""
    return "".join(c if c.isprintable() else " " for c in text)


@dataclass(frozen=True)
class To:
    """Marks a field that holds numbers of elements: of which list of the document."""

    collection: str


Whole = Annotated[int, BeforeValidator(_whole)]
Index = Annotated[Whole, Ge(0)]
Size = Annotated[Whole, Ge(1), Le(2**53)]
Offset = Annotated[Whole, Ge(0), Le(2**53)]
Unit = Annotated[float, Ge(0), Le(1)]
Pair = Annotated[list[float], Len(2, 2)]
Triple = Annotated[list[float], Len(3, 3)]
Quadruple = Annotated[list[float], Len(4, 4)]
Color = Annotated[list[Unit], Len(3, 3)]
Attributes = Annotated[dict[str, Index], To("accessors")]


class Item(BaseModel):
    """What every element of a document shares."""

    model_config = ConfigDict(alias_generator=to_camel, strict=True, allow_inf_nan=False, frozen=True)


class Named(Item):
    """An element that may have a name."""

    name: Annotated[str, AfterValidator(_printable)] = ""


class Asset(Item):
    """Which version of glTF this is."""

    version: Annotated[str, Field(pattern=r"^[0-9]+\.[0-9]+$")]
    min_version: Annotated[str | None, Field(pattern=r"^[0-9]+\.[0-9]+$")] = None


# Bytes and numbers ------------------------------------------------------------------------------------


class BufferExtensions(Item):
    """Extensions of a buffer."""

    meshopt: dict[str, Any] | None = Field(default=None, alias="EXT_meshopt_compression")


class Buffer(Named):
    """Bytes in a file, in the container, or in a data URI."""

    uri: str | None = None
    byte_length: Size
    extensions: BufferExtensions = BufferExtensions()


class MeshoptView(Item):
    """EXT_meshopt_compression: where the compressed bytes of a view are."""

    buffer: Annotated[Index, To("buffers")]
    byte_offset: Offset = 0
    byte_length: Size
    byte_stride: Annotated[Whole, Ge(1), Le(256)]
    count: Size
    mode: Literal["ATTRIBUTES", "TRIANGLES", "INDICES"]
    filter: Literal["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"] = "NONE"


class ViewExtensions(Item):
    """Extensions of a buffer view."""

    meshopt: MeshoptView | None = Field(default=None, alias="EXT_meshopt_compression")


class BufferView(Named):
    """A part of a buffer."""

    buffer: Annotated[Index, To("buffers")]
    byte_offset: Offset = 0
    byte_length: Size
    byte_stride: Annotated[Whole, Ge(4), Le(252)] | None = None
    extensions: ViewExtensions = ViewExtensions()


ComponentType = Annotated[Literal[5120, 5121, 5122, 5123, 5125, 5126], BeforeValidator(_whole)]


class SparseIndices(Item):
    """Which elements a sparse accessor replaces."""

    buffer_view: Annotated[Index, To("buffer_views")]
    byte_offset: Offset = 0
    component_type: Annotated[Literal[5121, 5123, 5125], BeforeValidator(_whole)]


class SparseValues(Item):
    """What it replaces them with."""

    buffer_view: Annotated[Index, To("buffer_views")]
    byte_offset: Offset = 0


class Sparse(Item):
    """The elements of an accessor that differ from its base."""

    count: Size
    indices: SparseIndices
    values: SparseValues


class Accessor(Named):
    """Numbers in a buffer view."""

    buffer_view: Annotated[Index | None, To("buffer_views")] = None
    byte_offset: Offset = 0
    component_type: ComponentType
    normalized: bool = False
    count: Size
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    sparse: Sparse | None = None


# Pictures and materials -------------------------------------------------------------------------------


class Image(Named):
    """A picture in a file, a buffer view or a data URI."""

    uri: str | None = None
    mime_type: str | None = None
    buffer_view: Annotated[Index | None, To("buffer_views")] = None


Wrap = Annotated[Literal[33071, 33648, 10497], BeforeValidator(_whole)]


class Sampler(Named):
    """How a picture is read."""

    mag_filter: Annotated[Literal[9728, 9729], BeforeValidator(_whole)] | None = None
    wrap_s: Wrap = 10497
    wrap_t: Wrap = 10497


class Texture(Named):
    """A picture and a sampler."""

    sampler: Annotated[Index | None, To("samplers")] = None
    source: Annotated[Index | None, To("images")] = None


class TextureTransform(Item):
    """KHR_texture_transform."""

    offset: Pair = [0.0, 0.0]
    rotation: float = 0.0
    scale: Pair = [1.0, 1.0]
    tex_coord: Index | None = None


class TextureInfoExtensions(Item):
    """Extensions of a use of a texture."""

    transform: TextureTransform | None = Field(default=None, alias="KHR_texture_transform")


class TextureInfo(Item):
    """A use of a texture."""

    index: Annotated[Index, To("textures")]
    tex_coord: Index = 0
    extensions: TextureInfoExtensions = TextureInfoExtensions()


class NormalTexture(TextureInfo):
    """A use of a texture as normal map."""

    scale: float = 1.0


class MetallicRoughness(Item):
    """The metallic-roughness model."""

    base_color_factor: Annotated[list[Unit], Len(4, 4)] = [1.0, 1.0, 1.0, 1.0]
    base_color_texture: TextureInfo | None = None
    metallic_factor: Unit = 1.0
    roughness_factor: Unit = 1.0
    metallic_roughness_texture: TextureInfo | None = None


class SpecularGlossiness(Item):
    """KHR_materials_pbrSpecularGlossiness, retired, yet files have it."""

    diffuse_factor: Annotated[list[Unit], Len(4, 4)] = [1.0, 1.0, 1.0, 1.0]
    diffuse_texture: TextureInfo | None = None
    specular_factor: Color = [1.0, 1.0, 1.0]
    glossiness_factor: Unit = 1.0


class EmissiveStrength(Item):
    """KHR_materials_emissive_strength."""

    emissive_strength: Annotated[float, Ge(0)] = 1.0


class Ior(Item):
    """KHR_materials_ior."""

    ior: Annotated[float, Ge(0)] = 1.5


class Specular(Item):
    """KHR_materials_specular, its factors."""

    specular_factor: Unit = 1.0
    specular_color_factor: Annotated[list[Annotated[float, Ge(0)]], Len(3, 3)] = [1.0, 1.0, 1.0]


class Transmission(Item):
    """KHR_materials_transmission."""

    transmission_factor: Unit = 0.0
    transmission_texture: TextureInfo | None = None


class Volume(Item):
    """KHR_materials_volume, as far as it says solid or thin."""

    thickness_factor: Annotated[float, Ge(0)] = 0.0


class MaterialExtensions(Item):
    """Extensions of a material."""

    emissive_strength: EmissiveStrength | None = Field(default=None, alias="KHR_materials_emissive_strength")
    unlit: dict[str, Any] | None = Field(default=None, alias="KHR_materials_unlit")
    ior: Ior | None = Field(default=None, alias="KHR_materials_ior")
    specular: Specular | None = Field(default=None, alias="KHR_materials_specular")
    transmission: Transmission | None = Field(default=None, alias="KHR_materials_transmission")
    volume: Volume | None = Field(default=None, alias="KHR_materials_volume")
    glossiness: SpecularGlossiness | None = Field(default=None, alias="KHR_materials_pbrSpecularGlossiness")


class Material(Named):
    """What a surface is made of."""

    pbr: MetallicRoughness = Field(default=MetallicRoughness(), alias="pbrMetallicRoughness")
    normal_texture: NormalTexture | None = None
    occlusion_texture: TextureInfo | None = None
    emissive_texture: TextureInfo | None = None
    emissive_factor: Color = [0.0, 0.0, 0.0]
    alpha_mode: Literal["OPAQUE", "MASK", "BLEND"] = "OPAQUE"
    alpha_cutoff: Annotated[float, Ge(0)] = 0.5
    double_sided: bool = False
    extensions: MaterialExtensions = MaterialExtensions()


# Meshes and what moves them ---------------------------------------------------------------------------


class DracoPrimitive(Item):
    """KHR_draco_mesh_compression."""

    buffer_view: Annotated[Index, To("buffer_views")]
    attributes: dict[str, Index]


class PrimitiveExtensions(Item):
    """Extensions of a primitive."""

    draco: DracoPrimitive | None = Field(default=None, alias="KHR_draco_mesh_compression")


class Primitive(Item):
    """One piece of a mesh, of one material."""

    attributes: Attributes = {}
    indices: Annotated[Index | None, To("accessors")] = None
    material: Annotated[Index | None, To("materials")] = None
    mode: Annotated[Whole, Ge(0), Le(6)] = 4
    targets: Annotated[list[dict[str, Index]], To("accessors")] = []
    extensions: PrimitiveExtensions = PrimitiveExtensions()


class Mesh(Named):
    """Pieces that move as one."""

    primitives: Annotated[list[Primitive], MinLen(1)]
    weights: list[float] = []


class Skin(Named):
    """Joints that bend a mesh."""

    inverse_bind_matrices: Annotated[Index | None, To("accessors")] = None
    skeleton: Annotated[Index | None, To("nodes")] = None
    joints: Annotated[list[Index], MinLen(1), To("nodes")]


class LightReference(Item):
    """KHR_lights_punctual of a node."""

    light: Annotated[Index, To("lights")]


class Instancing(Item):
    """EXT_mesh_gpu_instancing."""

    attributes: Attributes


class Visibility(Item):
    """KHR_node_visibility."""

    visible: bool = True


class NodeExtensions(Item):
    """Extensions of a node."""

    light: LightReference | None = Field(default=None, alias="KHR_lights_punctual")
    visibility: Visibility = Field(default=Visibility(), alias="KHR_node_visibility")
    instancing: Instancing | None = Field(default=None, alias="EXT_mesh_gpu_instancing")


class Node(Named):
    """A place in the hierarchy, and what is there."""

    children: Annotated[list[Index], To("nodes")] = []
    matrix: Annotated[list[float], Len(16, 16)] | None = None
    translation: Triple = [0.0, 0.0, 0.0]
    rotation: Quadruple = [0.0, 0.0, 0.0, 1.0]
    scale: Triple = [1.0, 1.0, 1.0]
    mesh: Annotated[Index | None, To("meshes")] = None
    skin: Annotated[Index | None, To("skins")] = None
    camera: Annotated[Index | None, To("cameras")] = None
    weights: list[float] | None = None
    extensions: NodeExtensions = NodeExtensions()


class Scene(Named):
    """Nodes shown together."""

    nodes: Annotated[list[Index], To("nodes")] = []


class AnimationTarget(Item):
    """What a channel moves; animation pointers name no node."""

    node: Annotated[Index | None, To("nodes")] = None
    path: str


class AnimationChannel(Item):
    """A sampler and what it moves."""

    sampler: Index
    target: AnimationTarget


class AnimationSampler(Item):
    """Values over time."""

    input: Annotated[Index, To("accessors")]
    output: Annotated[Index, To("accessors")]
    interpolation: Literal["LINEAR", "STEP", "CUBICSPLINE"] = "LINEAR"


class Animation(Named):
    """Motions that run together."""

    channels: list[AnimationChannel]
    samplers: list[AnimationSampler]


# Cameras and lights -----------------------------------------------------------------------------------


class Perspective(Item):
    """A pinhole camera."""

    yfov: Annotated[float, Gt(0)]
    znear: Annotated[float, Gt(0)]
    aspect_ratio: Annotated[float, Gt(0)] | None = None


class Orthographic(Item):
    """A camera of parallel rays."""

    xmag: float
    ymag: float
    znear: Annotated[float, Ge(0)]


class Camera(Named):
    """A camera of either kind."""

    type: Literal["perspective", "orthographic"]
    perspective: Perspective | None = None
    orthographic: Orthographic | None = None


class Spot(Item):
    """The cone of a spot light [rad]."""

    inner_cone_angle: Annotated[float, Ge(0)] = 0.0
    outer_cone_angle: Annotated[float, Gt(0)] = 0.7853981633974483


class Light(Named):
    """A light of KHR_lights_punctual."""

    type: Literal["point", "spot", "directional"]
    color: Annotated[list[Annotated[float, Ge(0)]], Len(3, 3)] = [1.0, 1.0, 1.0]
    intensity: Annotated[float, Ge(0)] = 1.0
    range: Annotated[float, Gt(0)] | None = None
    spot: Spot = Spot()


class PunctualLights(Item):
    """KHR_lights_punctual of the document."""

    lights: list[Light] = []


class DocumentExtensions(Item):
    """Extensions of the document."""

    punctual: PunctualLights = Field(default=PunctualLights(), alias="KHR_lights_punctual")


class Document(Item):
    """A whole file."""

    asset: Asset
    extensions_used: list[str] = []
    extensions_required: list[str] = []
    extensions: DocumentExtensions = DocumentExtensions()
    scene: Annotated[Index | None, To("scenes")] = None
    scenes: list[Scene] = []
    nodes: list[Node] = []
    meshes: list[Mesh] = []
    accessors: list[Accessor] = []
    buffer_views: list[BufferView] = []
    buffers: list[Buffer] = []
    materials: list[Material] = []
    textures: list[Texture] = []
    images: list[Image] = []
    samplers: list[Sampler] = []
    skins: list[Skin] = []
    animations: list[Animation] = []
    cameras: list[Camera] = []

    @property
    def lights(self) -> list[Light]:
        """Those of KHR_lights_punctual."""
        return self.extensions.punctual.lights
