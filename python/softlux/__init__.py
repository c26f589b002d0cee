"""softlux: global illumination of triangle scenes on a CPU, with the same bits every time.

    picture = softlux.render("scenes/cornell.json", size=(200, 200), quality="high")
    picture.write("cornell.exr")
    picture.rgb.mean(axis=(0, 1))       # a numpy array over the picture's own memory

Step by step: Scene.load(), Method(scene, **options), which is iterated over, Method.resolve(). Options have
the names and values of the command line (`softlux help settings`, or options() here). A call that fails
raises an Error. Different objects may be used by different threads at once, which then do run at once; one
object by one thread at a time. What has no class here is reached through `lib` and `ffi` (cffi).
"""
import os
from collections import namedtuple

import numpy

from ._library import ffi, lib

# ---- between C and Python ----


class Error(Exception):
    """A call of the library failed; str() is its one line."""


class UsageError(Error, ValueError):
    """What was asked for cannot be."""


class InputError(Error):
    """A file cannot be read, or what was given is not what it ought to be."""


class OutputError(Error):
    """A file cannot be written."""


class ResourcesError(Error, MemoryError):
    """No memory or threads; or more than the option "memory" allows."""


_ERRORS = {
    lib.SL_ERROR_USAGE: UsageError,
    lib.SL_ERROR_INPUT: InputError,
    lib.SL_ERROR_OUTPUT: OutputError,
    lib.SL_ERROR_RESOURCES: ResourcesError,
}


def _call(function, *arguments):
    """Calls a function whose last parameter is an sl_error, and raises what it describes."""
    error = ffi.new("sl_error *")
    status = function(*arguments, error)
    if status != lib.SL_OK:
        raise _ERRORS.get(status, Error)(_text(error.message))


def _made(type_name, destroy, function, *arguments):
    """Calls a function that makes something, to be destroyed when Python is done with it."""
    place = ffi.new(type_name + " **")
    _call(function, *arguments, place)
    return ffi.gc(place[0], destroy)


def _text(characters):
    return ffi.string(characters).decode("utf-8", "replace") if characters else None


def _vector(values):
    return ffi.new("float[3]", [float(v) for v in values])


def _plain(value):
    """A field of a struct as Python has such things."""
    if isinstance(value, bytes):
        return value.decode().strip("\0")
    if not isinstance(value, ffi.CData):
        return value
    return _text(value) if ffi.typeof(value).kind == "pointer" else tuple(value)


def _record(name, type_name, what):
    """Makes a named tuple of a struct's fields."""
    fields = [field for field, _ in ffi.typeof(type_name).fields if field != "reserved"]
    record = namedtuple(name, fields)
    record.__doc__ = what + ": " + type_name + " of softlux.h."
    record.of = classmethod(lambda kind, struct: kind(*(_plain(getattr(struct, f)) for f in kind._fields)))
    return record


Progress = _record("Progress", "sl_progress", "How far a method has come")
Comparison = _record("Comparison", "sl_comparison", "How far a picture is from another")
Option = _record("Option", "sl_setting", "One option")
Material = _record("Material", "sl_material_data", "A surface")
ErrorEstimate = _record("ErrorEstimate", "sl_error_estimate", "The error of a picture, without a reference")
Pass = namedtuple("Pass", "method name source buffer counters")
Pass.__doc__ = "One pass of a method: its name, where its paper has it, what it made (or None) and cost."


def _counters(counters):
    return {_text(lib.sl_counter_name(i)): counters.value[i] for i in range(lib.SL_COUNTERS)}


def version():
    """The version of the library that was found."""
    return _text(lib.sl_version())


# ---- pictures ----


class Image:
    """Planes of floats, in the library's memory: numpy arrays made of them keep it alive."""

    def __init__(self, values, channels=None):
        """Copies rows of pixels (Y), of their R, G, B, or of other channels that are named."""
        values = numpy.asarray(values, dtype=numpy.float32)
        if values.ndim not in (2, 3):
            raise UsageError(f"a picture has rows of pixels, or of pixels' channels, not {values.ndim} axes")
        planes = values[numpy.newaxis] if values.ndim == 2 else numpy.moveaxis(values, 2, 0)
        names = channels or {1: "Y", 3: "RGB"}.get(len(planes))
        if not names or len(names) != len(planes):
            raise UsageError(f"{len(planes)} channels want as many names")
        texts = [ffi.new("char[]", name.encode()) for name in names]
        self._handle = _made("sl_image", lib.sl_image_destroy, lib.sl_image_create, planes.shape[2],
                             planes.shape[1], len(texts), ffi.new("const char *[]", texts))
        self.planes[...] = planes

    @classmethod
    def _own(cls, handle):
        image = cls.__new__(cls)
        image._handle = handle
        return image

    @classmethod
    def read(cls, path):
        """Reads an EXR, PFM, HDR, PNG or JPEG file, known by its content."""
        return cls._own(_made("sl_image", lib.sl_image_destroy, lib.sl_image_read, os.fsencode(path)))

    @property
    def __array_interface__(self):
        image = self._handle
        return {"version": 3, "typestr": numpy.dtype(numpy.float32).str,
                "shape": (image.channels, image.height, image.width),
                "data": (int(ffi.cast("uintptr_t", image.planes)), False)}

    @property
    def planes(self):
        """All channels by row and column, without copying."""
        return numpy.asarray(self)

    @property
    def channels(self):
        """The names of the planes."""
        return tuple(_text(self._handle.channel_name[c]) for c in range(self._handle.channels))

    @property
    def size(self):
        """Width and height."""
        return self._handle.width, self._handle.height

    def __getitem__(self, channel):
        """One channel, "R" or "direct.R", by row and column, without copying."""
        return self.planes[self._index(channel)]

    def _index(self, channel):
        if channel not in self.channels:
            raise KeyError(f"no channel {channel}; there are {', '.join(self.channels)}")
        return self.channels.index(channel)

    def layer(self, name):
        """R, G, B of a layer, "direct", or of the picture, "", by row, column and channel: without copying
        where they follow each other, as in all that methods make."""
        names = [f"{name}.{c}" if name else c for c in "RGB"]
        first, second, third = (self._index(name) for name in names)
        step = second - first
        if third - second == step:
            return numpy.moveaxis(self.planes[first::step][:3], 0, 2)
        return numpy.stack([self[name] for name in names], axis=2)

    @property
    def rgb(self):
        """The picture by row, column and channel, without copying."""
        return self.layer("")

    @property
    def metadata(self):
        """What was told of the picture: method, settings, counters."""
        image = self._handle
        return {_text(m.key): _text(m.value) for m in image.metadata[0:image.metadata_count]}

    def set_metadata(self, key, value):
        """Adds an entry, or replaces it."""
        _call(lib.sl_image_set_metadata, self._handle, key.encode(), str(value).encode())

    def write(self, path):
        """Writes .exr, .pfm or .png, by the name."""
        _call(lib.sl_image_write, self._handle, os.fsencode(path))

    def srgb(self, exposure=0.0, curve="clip", automatic=False):
        """8 bits for a screen, by row, column and channel; curve: "clip" or "reinhard"."""
        tone = ffi.new("sl_tone *", [_choice("SL_TONE_", curve), exposure, automatic])
        values = numpy.empty(self.size[::-1] + (3,), dtype=numpy.uint8)
        _call(lib.sl_image_srgb, self._handle, tone, ffi.from_buffer("uint8_t[]", values))
        return values


def _choice(prefix, word):
    value = getattr(lib, prefix + word.upper(), None)
    if value is None:
        raise UsageError(f"unknown {word}")
    return value


def _image(values):
    return values if isinstance(values, Image) else Image(values)


def _compare(image, reference, mask, exposure, result, difference):
    options = ffi.new("sl_compare_options *")
    options.exposure_stops = exposure
    mask = None if mask is None else _image(mask)
    if mask:
        options.mask = mask._handle
    _call(lib.sl_image_compare, _image(image)._handle, _image(reference)._handle, options, result, difference)


def compare(image, reference, mask=None, exposure=0.0):
    """Tells how far a picture is from a reference: both an Image or an array; mask: where to look."""
    result = ffi.new("sl_comparison *")
    _compare(image, reference, mask, exposure, result, ffi.NULL)
    return Comparison.of(result)


def difference(image, reference, mask=None):
    """Where two pictures differ, in false colour: blue is too dark, red too bright."""
    place = ffi.new("sl_image **")
    _compare(image, reference, mask, 0.0, ffi.new("sl_comparison *"), place)
    return Image._own(ffi.gc(place[0], lib.sl_image_destroy))


# ---- scenes ----


class Scene:
    """Triangles, materials, lights and a camera."""

    def __init__(self, handle):
        self._handle = handle

    @classmethod
    def load(cls, path, *, allow_outside=False, up_axis="auto", eye=None, target=None, up=None, fov=None):
        """Loads a scene file or a mesh file; the camera may be another than the file's (fov in radians)."""
        options = ffi.new("sl_load_options *")
        view = ffi.new("sl_viewpoint *")
        options.allow_outside = allow_outside
        options.up_axis = _choice("SL_UP_", up_axis)
        for name, value in (("eye", eye), ("target", target), ("up", up)):
            if value is not None:
                setattr(view, "has_" + name, True)
                setattr(view, name, _vector(value))
        if fov is not None:
            view.has_fov, view.vertical_fov_rad = True, fov
        if (eye, target, up, fov) != (None, None, None, None):
            options.view = view
        return cls(_made("sl_scene", lib.sl_scene_destroy, lib.sl_scene_load_with, os.fsencode(path),
                         options))

    @property
    def warnings(self):
        """What loading had to decide or repair, a line each."""
        return [_text(lib.sl_scene_warning(self._handle, i))
                for i in range(lib.sl_scene_warning_count(self._handle))]

    @property
    def triangles(self):
        """How many there are."""
        return lib.sl_scene_triangle_count(self._handle)

    @property
    def memory(self):
        """Bytes that the scene holds."""
        return lib.sl_scene_memory_bytes(self._handle)

    @property
    def film(self):
        """Width and height that the scene's file asks for."""
        size = ffi.new("int[2]")
        lib.sl_scene_film(self._handle, size, size + 1)
        return tuple(size)

    @property
    def hash(self):
        """A number that is equal for equal scenes."""
        return lib.sl_scene_hash(self._handle)

    def write(self, path):
        """Writes the scene as it stands: NAME.json, and beside it meshes, textures and sky."""
        _call(lib.sl_scene_write, self._handle, os.fsencode(path))

    def find_object(self, name):
        """The number of the first object of that name."""
        return self._found(lib.sl_scene_find_object, "object", name)

    def find_material(self, name):
        """The number of the first material of that name; a quad light's has the name of the light."""
        return self._found(lib.sl_scene_find_material, "material", name)

    def _found(self, function, kind, name):
        """What has a number is known by it as well."""
        if not isinstance(name, str):
            return name
        number = function(self._handle, name.encode())
        if number == 0:
            raise UsageError(f"no {kind} is called {name}")
        return number

    @property
    def lights(self):
        """How many points, spots and directional lights there are, those that are turned off included."""
        return lib.sl_scene_light_count(self._handle)

    def material(self, material):
        """A Material as it is now, by its number or name."""
        return Material.of(self._material(material))

    def _material(self, material):
        data = ffi.new("sl_material_data *")
        number = self._found(lib.sl_scene_find_material, "material", material)
        if not lib.sl_scene_material(self._handle, number, data):
            raise UsageError(f"material {number}: there is none of that number")
        return data

    def vertices(self, thing):
        """Positions and normals of an object's vertices, before it is moved, as SceneEdit.vertices() takes
        them."""
        number = self._found(lib.sl_scene_find_object, "object", thing)
        count = lib.sl_scene_vertices(self._handle, number, ffi.NULL, ffi.NULL)
        positions, normals = numpy.zeros((2, count, 3), dtype="float32")
        lib.sl_scene_vertices(self._handle, number, ffi.from_buffer("float[]", positions),
                              ffi.from_buffer("float[]", normals))
        return positions, normals

    def edit(self):
        """Begins a SceneEdit: with scene.edit() as edit: ..."""
        return SceneEdit(self)

    def set_time(self, seconds):
        """Moves everything to its keyframes at a time; returns what has changed."""
        changes = ffi.new("unsigned *")
        _call(lib.sl_scene_set_time, self._handle, seconds, changes)
        return changes[0]

    def set_camera(self, eye, target, up, fov):
        """Looks from eye to target, fov in radians; returns what has changed."""
        _call(lib.sl_scene_set_camera, self._handle, _vector(eye), _vector(target), _vector(up), fov)
        return lib.SL_CHANGED_CAMERA


# ---- scenes from arrays, and their edits ----


def _array(name, values, type_name, *shape):
    """Values as C takes them; a side of None is of any length."""
    values = numpy.asarray(values)
    if type_name == "uint32_t" and values.dtype.kind not in "iu":
        raise UsageError(f"{name}: expected whole numbers, got {values.dtype}")
    if values.ndim != len(shape) or any(s not in (None, n) for s, n in zip(shape, values.shape)):
        raise UsageError(f"{name}: expected an array of {shape}, got {values.shape}")
    return numpy.ascontiguousarray(values, dtype=type_name.removesuffix("_t"))


def _struct(type_name, fields):
    """A struct of what is given, and all that it points to."""
    struct, types, kept = ffi.new(type_name + " *"), dict(ffi.typeof(type_name).fields), []
    struct.size = ffi.sizeof(type_name)
    for name, value in fields.items():
        if name not in types or name == "size":
            raise UsageError(f"unknown {name}; expected some of {', '.join(list(types)[1:])}")
        if value is None:
            continue
        kind = types[name].type
        if kind.kind == "pointer":
            value = ffi.new("char[]", value.encode()) if isinstance(value, str) else \
                ffi.from_buffer(kind.item.cname + "[]", value)
            kept.append(value)
        setattr(struct, name, [float(v) for v in value] if kind.kind == "array" else value)
    return struct, kept


def _columns(transform):
    return _array("transform", numpy.transpose(transform), "float64", 4, 4)


def _sky(radiance):
    """Width, height and values of a sky: R, G, B all around, or rows of them."""
    radiance = numpy.asarray(radiance)
    radiance = _array("radiance", radiance, "float32", *(None,) * (radiance.ndim - 1), 3)
    height, width = radiance.shape[:2] if radiance.ndim == 3 else (0, 0)
    return width, height, ffi.from_buffer("float[]", radiance)


def _mesh(positions, indices, normals=None, texture_coordinates=None, material=0, materials=None, name=None):
    """The fields of sl_mesh_data."""
    positions = _array("positions", positions, "float32", None, 3)
    indices = _array("indices", indices, "uint32_t", None, 3)
    vertices, triangles = len(positions), len(indices)
    if normals is not None:
        normals = _array("normals", normals, "float32", vertices, 3)
    if texture_coordinates is not None:
        texture_coordinates = _array("texture_coordinates", texture_coordinates, "float32", vertices, 2)
    if materials is not None:
        materials = _array("materials", materials, "uint32_t", triangles)
    return {"name": name, "vertex_count": vertices, "positions": positions, "normals": normals,
            "texture_coordinates": texture_coordinates, "triangle_count": triangles, "indices": indices,
            "materials": materials, "material": material}


class SceneBuilder:
    """Makes a scene from arrays by the rules for scene files. What is added is told apart by the numbers that
    come back; 0 is none. Fields are those of the header's structs, sl_material_data and so on."""

    def __init__(self):
        self._handle = _made("sl_scene_builder", lib.sl_scene_builder_destroy, lib.sl_scene_builder_create)
        self._borrowed = []

    def _add(self, function, type_name, **fields):
        struct, kept = _struct(type_name, fields)
        if fields.get("borrowed"):
            self._borrowed.append(kept)
        number = ffi.new("uint32_t *")
        _call(function, self._handle, struct, number)
        return number[0]

    def texture(self, values, name=None):
        """Rows of texels, row 0 at the top: uint8 as sRGB files have them, or floats in linear light."""
        values = numpy.asarray(values)
        values = values[:, :, numpy.newaxis] if values.ndim == 2 else values
        kind, field = ("uint8_t", "srgb") if values.dtype == numpy.uint8 else ("float32", "linear")
        values = _array("texture", values, kind, None, None, None)
        return self._add(lib.sl_scene_builder_texture, "sl_texture_data", name=name, width=values.shape[1],
                         height=values.shape[0], channels=values.shape[2], **{field: values})

    def material(self, **fields):
        """A surface: diffuse, specular, exponent, mirror, emission, two_sided, texture, alpha, bump, ..."""
        return self._add(lib.sl_scene_builder_material, "sl_material_data", **fields)

    def mesh(self, positions, indices, *, normals=None, texture_coordinates=None, material=0, materials=None,
             name=None, borrowed=False):
        """Triangles, which are not seen until they are placed. borrowed: the arrays are not copied, and must
        not be changed until the scene is built."""
        return self._add(lib.sl_scene_builder_mesh, "sl_mesh_data", borrowed=borrowed,
                         **_mesh(positions, indices, normals, texture_coordinates, material, materials, name))

    def instance(self, mesh, transform=None, material=0, name=None):
        """Places a mesh; transform: a matrix of 4 x 4 for columns of coordinates."""
        transform = None if transform is None else _columns(transform)
        struct, _kept = _struct("sl_instance_data", {"mesh": mesh, "transform": transform,
                                                     "material": material, "name": name})
        _call(lib.sl_scene_builder_instance, self._handle, struct)

    def light(self, kind, **fields):
        """A "point", "spot", "directional" or "quad": position, direction, edge1, edge2, strength, ..."""
        struct, _kept = _struct("sl_light_data", {"type": _choice("SL_LIGHT_", kind), **fields})
        _call(lib.sl_scene_builder_light, self._handle, struct)

    def environment(self, radiance):
        """A sky: R, G, B all around, or rows of R, G, B by latitude and longitude, the top one first."""
        _call(lib.sl_scene_builder_environment, self._handle, *_sky(radiance))

    def camera(self, eye, target, up, fov):
        """Looks from eye to target, fov in radians."""
        _call(lib.sl_scene_builder_camera, self._handle, _vector(eye), _vector(target), _vector(up), fov)

    def film(self, width, height):
        """The picture's size, where no option says another."""
        _call(lib.sl_scene_builder_film, self._handle, width, height)

    def build(self):
        """The Scene; the builder takes no more then."""
        try:
            return Scene(_made("sl_scene", lib.sl_scene_destroy, lib.sl_scene_builder_build, self._handle))
        finally:
            self._borrowed.clear()


class SceneEdit:
    """Changes of a scene, which take place together, or not at all: at the end of a with-block, unless it
    raises, or with commit(). Then Method.edit() follows. Numbers are those of the builder; objects and
    materials are known by their names, too. One that is refused leaves the others of its edit."""

    def __init__(self, scene):
        handle = _made("sl_scene_edit", lambda edit: (lib.sl_scene_edit_destroy(edit), scene),
                       lib.sl_scene_edit_begin, scene._handle)
        self._scene, self._handle, self._materials = scene, handle, {}

    def _call(self, function, *arguments):
        if not self._handle:
            raise UsageError("this edit is over")
        _call(function, self._handle, *arguments)

    def material(self, material, **fields):
        """Gives a material other values, those of SceneBuilder.material(); what is not given stays."""
        number = self._scene._found(lib.sl_scene_find_material, "material", material)
        before = self._materials.get(number) or self._scene._material(number)
        data = ffi.new("sl_material_data *", before[0])
        given, _kept = _struct("sl_material_data", fields)
        for name in fields.keys() - {"name"}:
            setattr(data, name, getattr(given, name))
        self._call(lib.sl_edit_material, number, data)
        self._materials[number] = data

    def light(self, light, *, strength=None, position=None, direction=None):
        """Turns a point, spot or directional light up or down (0: off), moves or turns it."""
        vectors = [ffi.NULL if value is None else ffi.new(kind, [float(v) for v in value])
                   for kind, value in (("float[3]", strength), ("double[3]", position),
                                       ("double[3]", direction))]
        self._call(lib.sl_edit_light, light, *vectors)

    def transform(self, thing, transform):
        """Moves an object from where it was built, by a matrix of 4 x 4 for columns of coordinates; None: it is
        where its keyframes have it, or where it was built."""
        number = self._scene._found(lib.sl_scene_find_object, "object", thing)
        columns = ffi.NULL if transform is None else ffi.from_buffer("double[]", _columns(transform))
        self._call(lib.sl_edit_transform, number, columns)

    def vertices(self, thing, positions, normals=None):
        """Deforms an object: all vertices that Scene.vertices() tells, elsewhere."""
        number = self._scene._found(lib.sl_scene_find_object, "object", thing)
        positions = _array("positions", positions, "float32", None, 3)
        if normals is not None:
            normals = ffi.from_buffer("float[]", _array("normals", normals, "float32", len(positions), 3))
        self._call(lib.sl_edit_vertices, number, len(positions), ffi.from_buffer("float[]", positions),
                   ffi.NULL if normals is None else normals)

    def _added(self, function, type_name, fields):
        struct, _kept = _struct(type_name, fields)
        number = ffi.new("uint32_t *")
        self._call(function, struct, number)
        return number[0]

    def add_object(self, positions, indices, **fields):
        """Adds a mesh, as SceneBuilder.mesh() takes it, of the scene's materials; returns its number."""
        return self._added(lib.sl_edit_add_object, "sl_mesh_data", _mesh(positions, indices, **fields))

    def remove_object(self, thing):
        """Takes away an object that was there before the edit."""
        self._call(lib.sl_edit_remove_object, self._scene._found(lib.sl_scene_find_object, "object", thing))

    def add_light(self, kind, **fields):
        """Adds a light, as SceneBuilder.light() does, but for quads; returns its number."""
        return self._added(lib.sl_edit_add_light, "sl_light_data",
                           {"type": _choice("SL_LIGHT_", kind), **fields})

    def environment(self, radiance):
        """Another sky, as SceneBuilder.environment() takes it; a black one takes it away."""
        self._call(lib.sl_edit_environment, *_sky(radiance))

    def camera(self, eye, target, up, fov):
        """Looks from eye to target, fov in radians."""
        self._call(lib.sl_edit_camera, _vector(eye), _vector(target), _vector(up), fov)

    def commit(self):
        """Changes the scene, and returns what has changed, SL_CHANGED_ bits."""
        handle, self._handle, changes = self._handle, None, ffi.new("unsigned *")
        if not handle:
            raise UsageError("this edit is over")
        ffi.gc(handle, None)  # the library destroys it, whatever comes of it
        _call(lib.sl_scene_edit_commit, handle, changes)
        return changes[0]

    def __enter__(self):
        return self

    def __exit__(self, kind, what, where):
        if kind is None and self._handle:
            self.commit()
        self._handle = None


# ---- settings ----


def _told_until_null(at, kind):
    i = 0
    while at(i):
        yield kind(at(i))
        i += 1


def options():
    """Every option: its name, bounds, defaults and help."""
    return tuple(_told_until_null(lib.sl_setting_at, Option.of))


def methods():
    """The names of all methods."""
    return tuple(_told_until_null(lib.sl_method_name, _text))


class Settings:
    """What a method is asked for, by the names of the command line; what is not set follows the quality."""

    def __init__(self, options=(), **more):
        """Options by name: Settings({"light-octree.depth": 6}, quality="high", gather_size=32)."""
        self._handle = _made("sl_settings", lib.sl_settings_destroy, lib.sl_settings_create)
        self._asked = {}
        for name, value in {**dict(options), **more}.items():
            self[name] = value

    @classmethod
    def of_picture(cls, image):
        """The settings that made a picture, as its metadata tell them."""
        known = {option.name.split(".")[-1] for option in options()}
        named = {key[len("softlux."):].replace("_", "-"): value for key, value in image.metadata.items()}
        told = {name: value for name, value in named.items() if name in known}
        method = {"method": told["method"]} if "method" in told else {}
        return cls({**method, **told}, size=image.size)

    def __setitem__(self, name, value):
        if isinstance(value, (tuple, list)):
            value = "x".join(str(v) for v in value)
        value = str(int(value) if isinstance(value, bool) else value)
        _call(lib.sl_settings_set, self._handle, name.replace("_", "-").encode(), value.encode())
        self._asked[name] = value

    def __getitem__(self, name):
        text = ffi.new("char[256]")
        _call(lib.sl_settings_get, self._handle, name.replace("_", "-").encode(), text, len(text))
        return _text(text)

    def keys(self):
        """The names of what was set: dict(settings), or Settings(settings, **more)."""
        return self._asked.keys()


# ---- methods ----


class Method:
    """A method at work on a scene. Iterating over it updates it until nothing is left to refine."""

    def __init__(self, scene, settings=None, *, on_pass=None, **options):
        """Settings, or options by name. on_pass is called with a Pass after each."""
        settings = Settings(settings or (), **options)
        self._raised = []
        observer = self._observer(on_pass) if on_pass else (ffi.NULL,)
        lib.sl_settings_observe(settings._handle, observer[0])
        # A method is destroyed before what it reads.
        self._handle = _made("sl_method", lambda method: (lib.sl_method_destroy(method), scene, observer),
                             lib.sl_method_create, scene._handle, settings._handle)

    def _observer(self, on_pass):
        raised = self._raised

        def tell(_, told):
            buffer = numpy.array(Image._own(told.buffer).planes) if told.buffer else None
            if not raised:
                on_pass(Pass(_text(told.method), _text(told.name), _text(told.source), buffer,
                             _counters(told.counters)))

        callback = ffi.callback("void(void *, sl_pass *)", tell,
                                onerror=lambda kind, what, where: raised.append(what))
        observer = ffi.new("sl_observer *")
        setattr(observer, "pass", callback)
        return observer, callback

    def _call(self, function, *arguments):
        _call(function, self._handle, *arguments)
        if self._raised:
            raise self._raised.pop()

    def update(self):
        """Computes one more batch, tenths of a second; returns the Progress."""
        progress = ffi.new("sl_progress *")
        self._call(lib.sl_method_update, progress)
        return Progress.of(progress)

    def __iter__(self):
        while True:
            progress = self.update()
            yield progress
            if progress.done:
                return

    def finish(self, on_progress=None):
        """Updates until nothing is left to refine, telling each Progress, and returns the picture."""
        for progress in self:
            if on_progress:
                on_progress(progress)
        return self.resolve()

    def resolve(self):
        """The picture so far: R, G, B and the method's layers, with all that made it as metadata."""
        place = ffi.new("sl_image **")
        self._call(lib.sl_method_resolve, place)
        return Image._own(ffi.gc(place[0], lib.sl_image_destroy))

    def edit(self, changes=0):
        """Follows the scene: what has changed since the method last saw it is found out."""
        self._call(lib.sl_method_edit, changes)

    def save(self, path):
        """Writes the method's cache to a file."""
        self._call(lib.sl_method_save, os.fsencode(path))

    def load(self, path):
        """Takes over a cache that was saved."""
        self._call(lib.sl_method_load, os.fsencode(path))

    @property
    def counters(self):
        """All that was counted since the method was created."""
        return _counters(lib.sl_method_counters(self._handle))

    @property
    def memory(self):
        """Bytes that the method holds, without the scene."""
        return lib.sl_method_memory_bytes(self._handle)


class ErrorProbe:
    """Tells how far pictures of a scene are from the converged one, by path tracing a few of their pixels."""

    def __init__(self, scene, settings=None, **options):
        """The settings that the pictures are made with."""
        self._handle = _made("sl_error_probe", lambda probe: (lib.sl_error_probe_destroy(probe), scene),
                             lib.sl_error_probe_create, scene._handle,
                             Settings(settings or (), **options)._handle)

    def estimate(self, image, probes=256, samples=16):
        """Judges a picture by so many pixels with so many samples each; returns an ErrorEstimate."""
        estimate = ffi.new("sl_error_estimate *")
        _call(lib.sl_error_probe_estimate, self._handle, image._handle, probes, samples, estimate)
        return ErrorEstimate.of(estimate)


def render(scene, settings=None, on_progress=None, **options):
    """The finished picture of a scene, or of a scene file."""
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    return Method(scene, settings, **options).finish(on_progress)
