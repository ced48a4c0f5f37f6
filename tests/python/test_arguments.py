"""Wrong arguments of public functions: the error names the argument, and no function of the module in C++."""
import inspect

import gltf_psplit
import pytest
from conftest import SAMPLES, torus

POINTS, FACES, *_ = torus(4, 5)
DATA = b"DRACO"
GLTF, PRIMITIVE = {}, {"attributes": {}}
ACCESSORS = {"POSITION": {"componentType": 5126, "type": "VEC3"}}


def asset():
    return gltf_psplit.load(SAMPLES / "seams.glb")


# A valid call, and for each argument a value of a wrong type.
CALLS = {
    gltf_psplit.decode: ({"data": DATA}, {"data": 3, "quantized": "yes", "threads": "many", "out": [1]}),
    gltf_psplit.decode_many: ({"data": [DATA]}, {"data": 3, "quantized": 2, "threads": 1.5, "return_exceptions": "x"}),
    gltf_psplit.decode_container: ({"data": DATA, "attributes": {"POSITION": 0}, "accessors": ACCESSORS}, {
        "data": 3, "attributes": 3, "accessors": 3, "extension": 3, "threads": None, "out": 3}),
    gltf_psplit.decode_primitive: ({"gltf": GLTF, "primitive": PRIMITIVE, "buffer_view": bytes}, {
        "gltf": 3, "primitive": [], "buffer_view": 3, "threads": "x"}),
    gltf_psplit.encode: ({"points": POINTS, "faces": FACES}, {
        "points": "x", "faces": object(), "quantization_bits": "x", "compression_level": None, "quantization_range": "far",
        "quantization_origin": "here", "create_metadata": 3, "preserve_order": None, "colors": "red", "tex_coord": object(),
        "normals": {}, "attributes": 3, "normal_bits": 1.5, "texcoord_bits": [], "bits": 5}),
    gltf_psplit.encode_container: ({"points": POINTS, "faces": FACES}, {
        "points": "x", "faces": object(), "patches": "two", "quantization_bits": "x", "compression_level": None,
        "quantization_range": "far", "quantization_origin": "here", "colors": "red", "tex_coord": object(), "normals": {},
        "attributes": 3, "normal_bits": 1.5, "texcoord_bits": [], "bits": 5, "threads": "x"}),
    gltf_psplit.load: ({"source": SAMPLES / "seams.glb"}, {"source": 3, "threads": [], "return_exceptions": 1}),
    gltf_psplit.Asset.buffer_view: ({"index": 0}, {"index": "first"}),
    gltf_psplit.Asset.instances: ({}, {"scene": "first"}),
}


def expect_named(error, argument):
    said = str(error)
    assert argument in said and "_native" not in said and "arg0" not in said and "incompatible" not in said and "(self" not in said


@pytest.mark.parametrize("function, argument", [(function, name) for function, (_, wrong) in CALLS.items() for name in wrong])
def test_types(function, argument):
    right, wrong = CALLS[function]
    of = [asset()] if function.__qualname__.startswith("Asset.") else []
    # gltf_psplit.Error, where a value is none of several.
    with pytest.raises((TypeError, gltf_psplit.Error)) as error:
        function(*of, **{**right, argument: wrong[argument]})
    expect_named(error.value, repr(wrong[argument]) if argument == "extension" else argument)


@pytest.mark.parametrize("function", CALLS)
def test_every_argument_is_tried(function):
    assert set(inspect.signature(function).parameters) - {"self"} == set(CALLS[function][1])


@pytest.mark.parametrize("function", [function for function, (right, _) in CALLS.items() if right])
def test_missing_arguments(function):
    right, _ = CALLS[function]
    of = [asset()] if function.__qualname__.startswith("Asset.") else []
    with pytest.raises(TypeError, match="missing") as error:
        function(*of)
    expect_named(error.value, next(iter(right)))


@pytest.mark.parametrize("value", [2**31, 2**70, -1])
def test_numbers_that_are_too_large(stream, value):
    for call in (lambda: gltf_psplit.decode(stream, threads=value), lambda: gltf_psplit.decode_many([stream], threads=value),
                 lambda: gltf_psplit.load(SAMPLES / "seams.glb", threads=value),
                 lambda: gltf_psplit.encode_container(POINTS, FACES, threads=value)):
        with pytest.raises(ValueError, match="threads"):
            call()
    with pytest.raises(IndexError, match="index"):
        asset().buffer_view(value)
    with pytest.raises(ValueError, match="patches"):
        gltf_psplit.encode_container(POINTS, FACES, patches=2 * value)


def test_names_and_items_of_wrong_types(stream):
    with pytest.raises(TypeError, match=r"data\[1\] is a int"):
        gltf_psplit.decode_many([stream, 3])
    with pytest.raises(TypeError, match="attributes has the key 3"):
        gltf_psplit.decode_container(stream, {3: 0}, {})
    right = ACCESSORS["POSITION"]
    for kind, accessor in ((TypeError, 3), (TypeError, {**right, "componentType": 5126.0}), (TypeError, {**right, "type": ["VEC3"]}),
                           (TypeError, {**right, "count": "many"}), (ValueError, {**right, "count": -1})):
        with pytest.raises(kind, match=r"accessors\['POSITION'\]"):
            gltf_psplit.decode_container(stream, {"POSITION": 0}, {"POSITION": accessor})
    with pytest.raises(TypeError, match=r"accessors\['indices'\]"):
        gltf_psplit.decode_container(stream, {"POSITION": 0}, {**ACCESSORS, "indices": {"count": "many"}})

    def primitive(unique_id):
        return {"attributes": {"POSITION": 0}, "extensions": {
            "KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": unique_id}}}}

    with pytest.raises(TypeError, match=r"buffer_view\(0\) returned is a NoneType"):
        gltf_psplit.decode_primitive({"accessors": [right]}, primitive(0), lambda index: None)
    # A fault in a file is an error of the file.
    for unique_id in ("0", -1):
        with pytest.raises(gltf_psplit.InvalidInputError, match=r"attributes\['POSITION'\]"):
            gltf_psplit.decode_primitive({"accessors": [right]}, primitive(unique_id), lambda index: stream)
    for text in ("5", b"5"):
        with pytest.raises(TypeError, match="quantization_range"):
            gltf_psplit.encode(POINTS, FACES, quantization_range=text)
