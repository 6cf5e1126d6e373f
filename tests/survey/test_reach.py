"""Fields that light next to nothing of a picture are remarked on; others are not."""

import mitsuba as mi
import pytest

from ddgi.frame import render_frame
from ddgi.probes.field import IrradianceField
from ddgi.survey.reach import remark, unreached
from probing import diffuse, load, rgb, room, small

INSIDE_THE_BLOCK = ((-0.2, -0.2, -0.2), (0.2, 0.2, 0.2))
WHOLE_ROOM = ((-0.9, -0.9, -0.9), (0.9, 0.9, 0.9))


def scene():
    """A lit room with a solid block in its middle."""
    block = {
        "type": "cube",
        "to_world": mi.ScalarTransform4f().scale(0.3),
        "bsdf": diffuse(0.5, two_sided=True),
    }
    bulb = {"type": "point", "position": [0.0, 0.7, 0.6], "intensity": rgb(1.0)}
    return load(
        room(diffuse(0.5)) | {"block": block, "bulb": bulb}, look=(0.8, 0.8, 0.8, 0, 0, 0), size=(64, 48)
    )


def lit(box):
    s, there = small(grid_box=box), scene()
    field = IrradianceField.fit(there, s)
    for tick in range(3):
        field, _ = render_frame(there, field, there.camera, tick, s)
    return there, field, s


def test_probes_in_a_block_light_nothing_and_it_is_said():
    assert "no probe sees any light" in remark(*lit(INSIDE_THE_BLOCK))


def test_a_room_full_of_probes_needs_no_remark():
    found = lit(WHOLE_ROOM)
    assert unreached(*found) < 0.01
    assert remark(*found) is None


def test_probes_behind_a_wall_are_said_to_see_little():
    """Two closed rooms, the probes in the other one, which is lit too."""
    s, there = small(grid_box=((2.2, -0.8, -0.8), (3.8, 0.8, 0.8))), room(diffuse(0.5))
    beside = mi.ScalarTransform4f().translate([3, 0, 0])
    there["other"] = {"type": "cube", "to_world": beside, "flip_normals": True, "bsdf": diffuse(0.5)}
    for name, x in (("bulb", 0.0), ("other-bulb", 3.0)):
        there[name] = {"type": "point", "position": [x, 0.5, 0.0], "intensity": rgb(1.0)}
    there = load(there, look=(0.8, 0.0, 0.0, -1, 0, 0), size=(64, 48))
    field = IrradianceField.fit(there, s)
    for tick in range(3):
        field, _ = render_frame(there, field, there.camera, tick, s)
    assert unreached(there, field, s) == pytest.approx(1)
    assert "100 % of what the camera sees is seen by no probe" in remark(there, field, s)


ROOM = """<scene version="3.0.0">
  <shape type="cube"><boolean name="flip_normals" value="true"/></shape>
  <shape type="cube"><transform name="to_world"><scale value="0.3"/></transform></shape>
  <emitter type="point"><point name="position" x="0" y="0.7" z="0.6"/></emitter>
</scene>"""


@pytest.mark.parametrize(("half", "said"), [(0.2, True), (0.9, False)])
def test_the_command_says_so(run, tmp_path, half, said):
    (tmp_path / "room.xml").write_text(ROOM)
    options = [
        "--look",
        "0.8,0.8,0.8,0,0,0",
        "--size",
        "32x24",
        "--frames",
        "2",
        "--set",
        "grid.counts=[4,4,4]",
    ]
    box = f"grid.box=[[-{half},-{half},-{half}],[{half},{half},{half}]]"
    code, _, err = run(
        "render", str(tmp_path / "room.xml"), "-o", str(tmp_path / "a.png"), "--set", box, *options
    )
    assert code == 0
    assert ("no probe sees any light" in err) == said
