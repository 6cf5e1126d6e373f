"""Mitsuba files of every age: what is dropped, what is replaced, and what is refused."""

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

from ddgi.errors import SceneError

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "scenes"
FOLDERS = ("classroom", "cornell-bitterli", "staircase2", "veach-ajar", "veach-bidir")


def load(folder, body, version="0.5.0"):
    from ddgi.scene.load import load_scene

    path = folder / "room.xml"
    path.write_text(f'<scene version="{version}">\n{body}\n</scene>\n')
    return load_scene(path)


def reference(scene):
    """The scene as Mitsuba renders it; it must accept everything that is left."""
    return mi.parser.instantiate(mi.parser.ParserConfig(mi.variant()), scene.source)


def noted(scene, *parts):
    assert any(all(part in note for part in parts) for note in scene.notes), scene.notes


def floor(bsdf):
    return f'<shape type="rectangle" id="floor">\n{bsdf}\n</shape>'


def surface(scene):
    return np.array(scene.materials.surface).reshape(-1, 4)[scene.shapes["floor"]]


def base(scene):
    return np.array(scene.materials.base).reshape(-1, 4)[scene.shapes["floor"]]


def test_integrator_sampler_film_and_filter_of_old(tmp_path):
    sensor = (
        '<sensor type="perspective"><film type="ldrfilm"><integer name="width" value="40"/>'
        '<integer name="height" value="30"/><string name="fileFormat" value="png"/>'
        '<rfilter type="nosuchfilter"/></film><sampler type="halton"/></sensor>'
    )
    body = f'<integrator type="irrcache"><integer name="maxDepth" value="3"/></integrator>\n{sensor}\n'
    scene = load(tmp_path, body + floor(""))
    assert scene.camera.size == (40, 30)
    for part in ("irrcache", "halton", "ldrfilm", "nosuchfilter"):
        noted(scene, part, "left out", "line")
    reference(scene)


def framed(integrator, sampler, film, rfilter):
    return (
        f'<integrator type="{integrator}"/><sensor type="perspective"><sampler type="{sampler}"/>'
        f'<film type="{film}"><rfilter type="{rfilter}"/></film></sensor>' + floor("")
    )


def test_names_that_no_mitsuba_ever_had(tmp_path):
    """Also those of another kind, and paths."""
    scene = load(tmp_path, framed("frobtracer", "haltonx", "diffuse", "../weird"), "3.0.0")
    noted(scene, "frobtracer", "line 2", "no such integrator, left out")
    noted(scene, "haltonx", "no such sampler, left out")
    noted(scene, "diffuse", "no such film, left out")
    noted(scene, "../weird", "no such reconstruction filter, left out")
    reference(scene)


@pytest.mark.parametrize("integrator", ["path", "prb", "aov"])  # C++, Python, one that needs a property
def test_what_mitsuba_has_goes_without_a_word(tmp_path, integrator):
    scene = load(tmp_path, framed(integrator, "stratified", "specfilm", "mitchell"), "3.0.0")
    assert not any("left out" in note for note in scene.notes)


def test_a_sensor_that_is_gone(tmp_path):
    scene = load(tmp_path, '<sensor type="sphericalcamera"/>' + floor(""))
    noted(scene, "sphericalcamera", "left out")
    reference(scene)


def test_a_property_that_is_gone(tmp_path):
    scene = load(tmp_path, floor('<bsdf type="roughconductor"><float name="extEta" value="1"/></bsdf>'))
    noted(scene, "roughconductor", "ext_eta", "line 3")
    reference(scene)


def test_a_property_that_a_dictionary_should_not_have():
    from ddgi.scene.load import load_scene

    with pytest.raises(SceneError, match=r"unknown property.*radios"):
        load_scene({"type": "scene", "ball": {"type": "sphere", "radios": 2.0}})


@pytest.mark.parametrize(
    ("bsdf", "alpha"),
    [
        ('<bsdf type="phong"><float name="exponent" value="48"/>{}</bsdf>', 0.2),
        (
            '<bsdf type="ward"><float name="alphaU" value="0.1"/><float name="alphaV" value="0.4"/>{}</bsdf>',
            0.2,
        ),
    ],
)
def test_glossy_materials_of_old(tmp_path, bsdf, alpha):
    scene = load(tmp_path, floor(bsdf.format('<rgb name="diffuseReflectance" value="0.1,0.2,0.3"/>')))
    noted(scene, "roughplastic instead", "line 3")
    np.testing.assert_allclose(base(scene)[:3] / base(scene)[0], [1, 2, 3], rtol=1e-4)
    assert 0.07 < base(scene)[0] < 0.1  # under the coat
    assert surface(scene)[1] == pytest.approx(alpha, abs=1e-6)
    reference(scene)


@pytest.mark.parametrize("coat", ["coating", "roughcoating"])
def test_a_coat_is_left_out(tmp_path, coat):
    inner = '<bsdf type="diffuse"><rgb name="reflectance" value="0.1,0.2,0.3"/></bsdf>'
    scene = load(tmp_path, floor(f'<bsdf type="{coat}"><float name="intIOR" value="1.5"/>{inner}</bsdf>'))
    noted(scene, coat, "diffuse instead")
    np.testing.assert_allclose(base(scene)[:3], [0.1, 0.2, 0.3], atol=1e-6)
    reference(scene)


def test_a_mixture_of_two(tmp_path):
    parts = "".join(
        f'<bsdf type="diffuse"><rgb name="reflectance" value="{v},{v},{v}"/></bsdf>' for v in (0.2, 0.6)
    )
    mixture = f'<bsdf type="mixturebsdf"><string name="weights" value="0.25,0.75"/>{parts}</bsdf>'
    scene = load(tmp_path, floor(mixture))
    np.testing.assert_allclose(base(scene)[:3], 0.5, atol=1e-6)
    reference(scene)


def test_what_lets_light_through_diffusely(tmp_path):
    scene = load(tmp_path, floor('<bsdf type="difftrans"/>'))
    noted(scene, "principledthin instead")
    reference(scene)


@pytest.mark.parametrize("light", ["sun", "sky"])
def test_sun_and_sky_of_old(tmp_path, light):
    scene = load(tmp_path, f'<emitter type="{light}"><float name="stretch" value="1"/></emitter>' + floor(""))
    noted(scene, light, "sunsky instead")
    reference(scene)


def test_skies_of_old_have_y_up(tmp_path):
    sky = '<emitter type="sunsky"><vector name="sunDirection" x="0" y="1" z="0.2"/></emitter>'
    noted(load(tmp_path, sky + floor("")), "sunsky", "turned")
    new = load(tmp_path, sky.replace("sunDirection", "sun_direction") + floor(""), "3.0.0")
    assert not any("turned" in note for note in new.notes)


def test_a_plugin_without_a_substitute(tmp_path):
    with pytest.raises(SceneError) as caught:
        load(tmp_path, floor('<bsdf type="irawan"/>'))
    text = str(caught.value)
    assert "\n" not in text
    for part in ("irawan", "line 3", "remove the element"):
        assert part in text, text


def test_files_are_those_beside_the_scene(tmp_path):
    """Though another folder that Mitsuba searches has one of the same name."""
    triangle = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nf 1 2 3\n"
    for name, size in (("here", 1), ("elsewhere", 7)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mesh.obj").write_text(triangle.format(size))
    mi.file_resolver().prepend(str(tmp_path / "elsewhere"))
    mesh = '<shape type="obj"><string name="filename" value="mesh.obj"/></shape>'
    scene = load(tmp_path / "here", mesh, "3.0.0")
    np.testing.assert_allclose(scene.bounds[1], [1, 1, 0], atol=1e-6)
    (tmp_path / "here" / "mesh.obj").unlink()
    with pytest.raises(SceneError, match=r"mesh\.obj.*file not found"):
        load(tmp_path / "here", mesh, "3.0.0")


@pytest.mark.scenes
@pytest.mark.parametrize("file", ["scene.xml", "scene_mi3.xml"])
@pytest.mark.parametrize("folder", FOLDERS)
def test_shared_scenes(folder, file):
    """They load, or say in one line what is missing."""
    from ddgi.scene.load import load_scene

    path = SHARED / folder / file
    if not path.exists():
        pytest.skip(f"{folder}/{file} is not part of the package")
    try:
        assert load_scene(path).triangles > 0
    except SceneError as error:
        assert "\n" not in str(error)
        assert "file not found" in str(error)
        assert "line" in str(error)
