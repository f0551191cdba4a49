"""Small files of every kind that the readers take: `seeds.py FOLDER [SCENES…]`.

There is a folder for each fuzz target. Files of the given folders that are small enough are
taken along.
"""

import base64
import json
import struct
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path

LARGEST = 40_000

OBJ = """mtllib none.mtl
o thing
v 0 0 0
v 1 0 0 0.5 0.5 0.5
v 1 1 0
v\t0 1 0
vt 0 0
vt 1 0.25
vn 0 0 2
g one
usemtl stone
f 1/1/1 2/2/1 3/1/1 4/2/1
f -1//-1 -2 \\
-3/1
"""

PLY_HEADER = """ply
format {} 1.0
comment a comment
element vertex 3
property float x
property float y
property double z
property float nx
property float ny
property float nz
property half u
property float v
property uchar red
property ushort green
property int blue
property float foo_x
property float foo_y
property float foo_z
element edge 1
property list short float values
element face 2
property list uchar int vertex_indices
property float id_0
end_header
"""

XML = (Path(__file__).parent / "scene.xml").read_text()


def ply() -> Iterator[bytes]:
    """In text and in both byte orders."""
    rows = [(x, x * x, 0.1, 0, 0, 1, 0.5, 0.25, 200, 30000, -7, 1, 2, 3) for x in range(3)]
    text = "\n".join(" ".join(map(str, row)) for row in rows) + "\n1 0.5\n3 0 1 2 7\n4 0 1 2 0 8\n"
    yield (PLY_HEADER.format("ascii") + text).encode()
    for name, order in [("binary_little_endian", "<"), ("binary_big_endian", ">")]:
        body = b"".join(struct.pack(order + "ffdfffefBHifff", *row) for row in rows)
        body += struct.pack(order + "hf", 1, 0.5) + struct.pack(order + "B3if", 3, 0, 1, 2, 7)
        yield (
            PLY_HEADER.format(name).encode() + body + struct.pack(order + "B4if", 4, 0, 1, 2, 0, 8)
        )


def serialized() -> Iterator[bytes]:
    """Meshes of both versions and precisions, two in a file, and what is in their streams."""
    for version, double in [(3, False), (3, True), (4, False), (4, True)]:
        kind = "d" if double else "f"
        data = struct.pack("<I", 0xB | (0x2000 if double else 0x1000)) + (
            b"name\0" if version == 4 else b""
        )
        data += struct.pack("<QQ", 3, 1) + struct.pack(f"<{3 * 11}{kind}", *range(33))
        data += struct.pack("<3I", 0, 1, 2)
        mesh = struct.pack("<HH", 0x041C, version) + zlib.compress(data)
        width = "I" if version == 3 else "Q"
        yield mesh
        yield mesh + mesh + struct.pack(f"<2{width}I", 0, len(mesh), 2)
        yield data


def gltf() -> Iterator[bytes]:
    """A scene with textures, lights and a camera, as text and as GLB."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    data = positions + struct.pack("<6f", 0, 0, 1, 0, 0, 1) + struct.pack("<3H", 0, 1, 2) + b"\0\0"
    views = [(0, 36), (36, 24), (60, 6)]
    texture = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    metal = {
        "baseColorTexture": texture,
        "roughnessFactor": 0.5,
        "metallicRoughnessTexture": texture,
    }
    extensions = {
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": texture},
        "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.3},
        "KHR_materials_transmission": {"transmissionFactor": 0.5},
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2},
        "KHR_materials_specular": {"specularFactor": 0.5},
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.5},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_emissive_strength": {"emissiveStrength": 3},
    }
    scene = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 1, 2], "extras": {"pathspace": {"environment": [1, 1, 1]}}}],
        "nodes": [
            {"mesh": 0, "rotation": [0, 0, 0, 1]},
            {"camera": 0, "translation": [0, 0, 5]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "children": [3]},
            {"extras": {"pathspace": {"sphere": {"radius": 1, "material": "coat"}}}},
        ],
        "meshes": [
            {
                "primitives": [
                    {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
                ]
            }
        ],
        "materials": [
            {
                "name": "coat",
                "pbrMetallicRoughness": metal,
                "normalTexture": texture,
                "alphaMode": "BLEND",
                "emissiveFactor": [1, 1, 1],
                "doubleSided": True,
                "extensions": extensions,
            }
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071, "magFilter": 9728}],
        "images": [{"uri": "a.png"}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "extensions": {
            "KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 0.5}}]}
        },
        "extensionsUsed": ["KHR_lights_punctual"],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": length} for start, length in views
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "buffers": [{"byteLength": len(data)}],
    }
    inside = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    for uri in [inside, "a.bin"]:
        yield json.dumps({**scene, "buffers": [{"byteLength": len(data), "uri": uri}]}).encode()
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    yield (
        struct.pack("<4sIII4s", b"glTF", 2, size, len(text), b"JSON")
        + text
        + struct.pack("<I4s", len(data), b"BIN\0")
        + data
    )


def main() -> None:
    """Writes all."""
    top, *scenes = map(Path, sys.argv[1:])
    parts = [line for line in XML.splitlines() if line.startswith("  <") and line.endswith("/>")]
    wrapped = [f'<scene version="3.0.0">{part}</scene>' for part in parts]
    seeds = {
        "obj": [OBJ.encode()],
        "ply": list(ply()),
        "serialized": list(serialized()),
        "xml": [XML.encode(), *(text.encode() for text in wrapped)],
        "gltf": list(gltf()),
    }
    endings = {
        ".obj": "obj",
        ".ply": "ply",
        ".serialized": "serialized",
        ".xml": "xml",
        ".gltf": "gltf",
        ".glb": "gltf",
    }
    for folder in scenes:
        for path in sorted(folder.rglob("*")):
            if path.is_file() and path.suffix in endings and path.stat().st_size <= LARGEST:
                seeds[endings[path.suffix]].append(path.read_bytes())
    for target, files in seeds.items():
        (top / target).mkdir(parents=True, exist_ok=True)
        for number, data in enumerate(files):
            (top / target / f"seed{number}").write_bytes(data)
        print(f"{target}: {len(files)} seeds")


if __name__ == "__main__":
    main()
