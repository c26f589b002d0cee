"""The package on the library that SOFTLUX_LIBRARY names, run at the repository's root."""
import gc
import re
import subprocess
import sys
import threading
from pathlib import Path

import numpy
import pytest
import softlux

ROOM = "scenes/cornell.json"
SMALL = {"size": (16, 12), "quality": "draft", "spp": 1}


def test_a_golden_image():
    golden = softlux.render(ROOM, size=(24, 24), quality="draft", threads=1)  # or Image.read("golden.exr")
    picture = softlux.render(ROOM, size=(24, 24), quality="draft", threads=2)
    assert softlux.compare(picture, golden).identical


def test_all_that_the_header_declares_is_there():
    header = Path("include/softlux.h").read_text(encoding="utf-8")
    functions = re.findall(r"^SL_API[^(]*?(sl_\w+)\(", header, flags=re.MULTILINE)
    assert len(functions) > 50
    assert all(callable(getattr(softlux.lib, name)) for name in functions)
    assert softlux.version() == re.search(r'SL_VERSION "(.*)"', header)[1]


# ---- pictures ----


def test_arrays_are_views_that_keep_the_picture():
    picture = softlux.render(ROOM, method="path", **SMALL)
    red, rgb, direct = picture["R"], picture.rgb, softlux.render(ROOM, **SMALL).layer("direct")
    assert picture.size == (16, 12) and rgb.shape == direct.shape == (12, 16, 3)
    assert all(numpy.shares_memory(view, picture.planes) for view in (red, rgb))
    before = rgb.copy()
    rgb[3, 5, 0] = 7
    assert red[3, 5] == 7 and picture["R"][3, 5] == 7
    rgb[3, 5, 0] = before[3, 5, 0]
    del picture, red
    gc.collect()
    others = [softlux.Image(numpy.zeros((12, 16, 3))) for _ in range(99)]
    assert (rgb == before).all() and len(others) == 99
    with pytest.raises(KeyError, match="no channel Z; there are .*R"):
        softlux.Image(before)["Z"]


def test_pictures_come_from_arrays_and_go_to_files(tmp_path):
    values = numpy.random.default_rng(1).random((5, 7, 3), dtype=numpy.float32)
    picture = softlux.Image(values)
    picture.set_metadata("who", "a test")
    picture.write(tmp_path / "picture.exr")
    back = softlux.Image.read(tmp_path / "picture.exr")
    assert (back.rgb == values).all() and back.metadata["who"] == "a test"
    assert softlux.Image(values[:, :, 0]).channels == ("Y",)
    assert (softlux.Image(values).srgb()[values > 1] == 255).all() and picture.srgb().dtype == numpy.uint8
    for wrong in (numpy.zeros(3), numpy.zeros((2, 2, 5))):
        with pytest.raises(softlux.UsageError):
            softlux.Image(wrong)


def test_pictures_are_compared_as_numpy_would():
    x, r = numpy.random.default_rng(2).random((2, 8, 8, 3), dtype=numpy.float32)
    mask = numpy.zeros((8, 8))
    mask[2:5] = 1
    told, masked = softlux.compare(x, r), softlux.compare(x, r, mask=mask)
    assert told.rmse == pytest.approx(numpy.sqrt(((x - r) ** 2).mean())) and told.values == x.size
    assert masked.rmse == pytest.approx(numpy.sqrt(((x - r)[2:5] ** 2).mean())) and not masked.identical
    assert softlux.difference(x, r).size == (8, 8)
    with pytest.raises(softlux.InputError, match="size|8"):
        softlux.compare(x, r[:4])


# ---- scenes and settings ----


def test_what_fails_is_an_exception_with_its_line(tmp_path):
    (tmp_path / "bad.json").write_text('{"softlux": 1,\n "meshes": 012}')
    with pytest.raises(softlux.InputError, match="bad.json:2"):
        softlux.Scene.load(tmp_path / "bad.json")
    with pytest.raises(softlux.InputError, match="nowhere"):
        softlux.Scene.load("nowhere.json")
    with pytest.raises(softlux.OutputError):
        softlux.Image(numpy.zeros((1, 1, 3))).write(tmp_path / "nowhere" / "picture.exr")
    with pytest.raises(ValueError, match="did you mean light-octree.depth"):
        softlux.Settings({"light-octree.dpth": 6})
    with pytest.raises(softlux.UsageError, match="gather-size: .*even"):
        softlux.render(ROOM, gather_size=7, **SMALL)
    with pytest.raises(MemoryError):
        softlux.render(ROOM, memory=1, **SMALL)


def test_a_scene_tells_of_itself_and_moves():
    scene = softlux.Scene.load("scenes/moving-ball.json")
    hash_before = scene.hash
    method = softlux.Method(scene, SMALL)
    method.finish()
    method.edit(scene.set_time(0.5))
    moved = method.finish()
    assert scene.hash != hash_before and scene.triangles > 10 and scene.memory > 1000 and scene.warnings == []
    assert not softlux.compare(moved, softlux.render("scenes/moving-ball.json", SMALL)).identical
    method.edit(scene.set_camera((0, 1, 3), (0, 1, 0), (0, 1, 0), 0.5))
    assert numpy.isfinite(method.finish().rgb).all()
    assert softlux.Scene.load(ROOM, eye=(0.5, 0.5, 0.9), fov=1).hash != softlux.Scene.load(ROOM).hash


BOX = numpy.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=numpy.float32)
SIDES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
         [0, 6, 4], [1, 5, 7], [1, 7, 3]]


def test_a_scene_from_arrays_is_the_one_of_files(tmp_path):
    lines = [f"v {x} {y} {z}\n" for x, y, z in BOX] + [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in SIDES]
    (tmp_path / "box.obj").write_text("".join(lines))
    (tmp_path / "box.json").write_text("""{"softlux": 1, "film": {"width": 16, "height": 12},
        "materials": {"red": {"diffuse": [0.75, 0.25, 0.125]}},
        "meshes": [{"file": "box.obj", "material": "red",
                    "transform": [2, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0.5, 0, 0, 1]}],
        "environment": {"radiance": [0.5, 0.5, 1]},
        "lights": [{"type": "point", "position": [0, 3, 1], "intensity": [9, 9, 9]}],
        "camera": {"eye": [0, 2, 6], "target": [0, 0, 0], "up": [0, 1, 0], "fov_deg": 45}}""")
    builder = softlux.SceneBuilder()
    red = builder.material(diffuse=(0.75, 0.25, 0.125), name="red")
    box = builder.mesh(BOX, SIDES, material=red, borrowed=True)
    builder.instance(box, [[2, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    builder.environment((0.5, 0.5, 1))
    builder.light("point", position=(0, 3, 1), strength=(9, 9, 9))
    builder.camera((0, 2, 6), (0, 0, 0), (0, 1, 0), numpy.radians(45))
    builder.film(16, 12)
    scene = builder.build()
    file = softlux.Scene.load(tmp_path / "box.json")
    assert scene.film == file.film == (16, 12) and scene.triangles == file.triangles == 12
    options = {"quality": "draft", "method": "path", "spp": 2}
    scene.write(tmp_path / "written.json")
    for same in (file, softlux.Scene.load(tmp_path / "written.json")):
        assert softlux.compare(softlux.render(scene, options), softlux.render(same, options)).identical
    with pytest.raises(softlux.UsageError):
        builder.build()


def test_what_a_scene_cannot_be_made_of_is_refused():
    builder = softlux.SceneBuilder()
    assert builder.texture(numpy.zeros((2, 3, 3), dtype=numpy.uint8)) == 1
    assert builder.texture(numpy.full((4, 4), 0.5)) == 2
    for wrong, arrays in (("positions", (BOX[:, :2], SIDES)), ("indices", (BOX, [[0.5, 1, 2]])),
                          ("indices", (BOX, [0, 1, 2]))):
        with pytest.raises(softlux.UsageError, match=wrong):
            builder.mesh(*arrays)
    with pytest.raises(softlux.UsageError, match="normals: .*8"):
        builder.mesh(BOX, SIDES, normals=BOX[:3])
    with pytest.raises(softlux.InputError, match="chair.*99"):
        builder.mesh(BOX, [[0, 1, 99]], name="chair")
    with pytest.raises(softlux.UsageError, match="unknown colour; .*diffuse"):
        builder.material(colour=(1, 0, 0))
    with pytest.raises(softlux.InputError):
        builder.material(diffuse=(2, 0, 0))
    with pytest.raises(softlux.UsageError, match="unknown lamp"):
        builder.light("lamp")


def room(colour=(0.75, 0.25, 0.125), power=9, sky=(0.5, 0.5, 1), eye=(0, 2, 6), width=1):
    builder = softlux.SceneBuilder()
    boxes = builder.mesh(BOX, SIDES, material=builder.material(diffuse=colour, name="red"), name="box")
    builder.instance(boxes, numpy.diag([width, 1, 1, 1]))
    builder.environment(sky)
    builder.light("point", position=(0, 3, 1), strength=(power, 9, 9))
    builder.camera(eye, (0, 0, 0), (0, 1, 0), 0.75)
    return builder.build()


def test_an_object_goes_back_to_where_it_was_built():
    scene = room()
    built = scene.hash
    with scene.edit() as edit:
        edit.transform("box", numpy.diag([2, 1, 1, 1]))
    assert scene.hash != built
    with scene.edit() as edit:
        edit.transform("box", None)
    assert scene.hash == built


def test_an_edited_scene_is_the_one_that_is_built_so():
    scene, options = room(), {**SMALL, "method": "direct-radiance"}
    assert scene.lights == 1 and scene.find_object("box") == scene.find_material("red") == 1
    method = softlux.Method(scene, options)
    before = method.finish()
    with scene.edit() as edit:
        edit.transform("box", numpy.diag([2, 1, 1, 1]))
        edit.material("red", diffuse=(0.25, 0.5, 0.5))
        edit.material(1, exponent=10)
        edit.light(1, strength=(7, 9, 9))
        edit.light(1, position=(0, 3, 1))
        edit.environment((0.25, 0.5, 1))
        edit.camera((0, 2, 7), (0, 0, 0), (0, 1, 0), 0.75)
    built = room((0.25, 0.5, 0.5), 7, (0.25, 0.5, 1), (0, 2, 7), 2)
    with built.edit() as edit:
        edit.material(1, exponent=10)
    red = scene.material(1)
    assert scene.hash == built.hash and red.exponent == 10 and red.name == "red"
    method.edit()
    after = method.finish()
    assert softlux.compare(after, softlux.render(built, options)).identical
    assert not softlux.compare(after, before).identical


def test_objects_and_lights_come_and_go_and_change_their_shape():
    scene, options = room(), {**SMALL, "method": "splatting"}
    method = softlux.Method(scene, options)
    method.finish()
    positions, normals = scene.vertices("box")
    assert positions.shape == normals.shape and len(positions) > 3
    with scene.edit() as edit:
        new = edit.add_object([[0, 1, 0], [1, 1, 0], [0, 2, 0]], [[0, 1, 2]], material=1, name="kite")
        edit.transform(new, numpy.diag([0.5, 1, 1, 1]))
        assert edit.add_light("point", position=(0, 2, 0), strength=(1, 1, 1)) == 2
        edit.vertices("box", positions * [1, 0.5, 1])
    assert scene.find_object("kite") == new and scene.lights == 2
    method.edit()
    assert softlux.compare(method.finish(), softlux.render(scene, options)).identical
    before = scene.triangles
    with scene.edit() as edit:
        edit.remove_object("kite")
    assert scene.triangles == before - 1
    with pytest.raises(softlux.UsageError, match="no object"):
        scene.find_object("kite")


def test_an_edit_that_is_refused_changes_nothing():
    scene = room()
    hash_before = scene.hash
    with pytest.raises(softlux.InputError, match="'diffuse' from 0 to 1"):
        with scene.edit() as edit:
            edit.light(1, strength=(1, 1, 1))
            edit.material("red", diffuse=(2, 0, 0))
    with pytest.raises(softlux.InputError, match="object 'box'"):
        with scene.edit() as edit:
            edit.transform("box", numpy.diag([1e39, 1, 1, 1]))
    for wrong in (lambda e: e.transform("chair", numpy.eye(4)), lambda e: e.material(7, exponent=1),
                  lambda e: e.light(2), lambda e: e.transform(1, numpy.eye(3)),
                  lambda e: e.material("red", colour=(1, 1, 1))):
        with pytest.raises(softlux.UsageError):
            wrong(scene.edit())
    edit = scene.edit()
    assert edit.commit() == 0 and scene.hash == hash_before
    with pytest.raises(softlux.UsageError, match="over"):
        edit.commit()


def test_options_are_those_of_the_one_table():
    names = [option.name for option in softlux.options()]
    assert {"size", "quality", "light-octree.depth"} <= set(names) and all(o.help for o in softlux.options())
    depth = next(option for option in softlux.options() if option.name == "light-octree.depth")
    assert depth.minimum < depth.by_quality[1] < depth.maximum and depth.methods == "light-octree"
    settings = softlux.Settings({"light-octree.depth": 6}, size=(64, 48), caustics=True, gather_size=32)
    assert [settings[n] for n in ("light-octree.depth", "size", "caustics", "gather-size")] == \
        ["6", "64x48", "true", "32"]
    assert dict(softlux.Settings(settings, size="8x8"))["size"] == "8x8"
    assert "splatting" in softlux.methods() and "path" in softlux.methods()


def test_a_picture_tells_the_settings_that_make_it_again():
    picture = softlux.render(ROOM, {"light-octree.depth": 4}, method="light-octree", **SMALL)
    settings = softlux.Settings.of_picture(picture)
    assert settings["light-octree.depth"] == "4"
    assert softlux.compare(softlux.render(ROOM, settings), picture).identical


# ---- methods ----


def test_a_method_is_iterated_over_and_tells_its_passes():
    passes, told = [], []
    method = softlux.Method(softlux.Scene.load(ROOM), SMALL, on_pass=passes.append)
    gc.collect()  # the scene is the method's alone
    picture = method.finish(told.append)
    assert told[-1].done and told[-1].batches == len(told) and all(0 <= p.fraction <= 1 for p in told)
    assert method.counters["records"] > 0 and method.memory > 0
    assert passes[0].method == "splatting" and {p.buffer.ndim for p in passes if p.buffer is not None} == {3}
    assert picture.metadata["softlux.batches"] == str(len(told))


def test_what_a_callback_raises_reaches_the_caller():
    def refuse(_):
        raise ZeroDivisionError("mine")
    for arguments in ({"on_pass": refuse}, {}):
        with pytest.raises(ZeroDivisionError, match="mine"):
            softlux.Method(softlux.Scene.load(ROOM), SMALL, **arguments).finish(refuse)


def test_methods_in_threads_share_a_scene_and_give_the_same_bits():
    scene, pictures = softlux.Scene.load(ROOM), []
    threads = [threading.Thread(target=lambda: pictures.append(softlux.render(scene, SMALL)))
               for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(pictures) == 3 and all((p.planes == pictures[0].planes).all() for p in pictures)


def test_the_error_of_a_picture_is_estimated():
    scene = softlux.Scene.load(ROOM)
    estimate = softlux.ErrorProbe(scene, SMALL).estimate(softlux.render(scene, SMALL), probes=64, samples=4)
    assert 0 <= estimate.least <= estimate.rel_rmse <= estimate.bound and estimate.probes > 0


# ---- what is written about it ----


def test_the_examples_of_the_page_run(tmp_path, monkeypatch):
    page = Path("docs/python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```$", page, flags=re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 3
    (tmp_path / "scenes").symlink_to(Path("scenes").resolve())
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(block, names)


def test_the_example_draws_the_error_over_time(tmp_path):
    drawn = tmp_path / "error.svg"
    command = [sys.executable, "examples/error_over_time.py", ROOM, str(drawn), "16x16", "4"]
    subprocess.run(command, check=True)
    assert drawn.read_text().count("<polyline") == 2
