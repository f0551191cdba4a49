"""Writes a scene as glTF 2.0: `scene.gltf` (JSON) and `scene.bin` (vertices and indices).

The bytes depend on the scene alone: keys stand in the order of their making, numbers outside the
binary file are rounded to twelve digits, so that no platform's mathematical library shows.
"""

from __future__ import annotations

import json
import math
import re
import struct
from dataclasses import dataclass, field
from typing import Any

from shapes import Shape, icosphere
from vectors import Vec3, look_along, sub

Json = dict[str, Any]
Rgb = tuple[float, float, float]

FLOAT, UNSIGNED_SHORT = 5126, 5123
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


@dataclass
class GltfScene:
    """One scene under construction; everything is in metres, Y up, in world coordinates."""

    name: str
    settings: Json
    """The scene's `extras.pathspace`: film, environment, reference."""
    nodes: list[Json] = field(default_factory=list)
    meshes: list[Json] = field(default_factory=list)
    materials: list[Json] = field(default_factory=list)
    cameras: list[Json] = field(default_factory=list)
    accessors: list[Json] = field(default_factory=list)
    extensions: set[str] = field(default_factory=set)
    vertices: bytearray = field(default_factory=bytearray)
    indices: bytearray = field(default_factory=bytearray)
    triangles: int = 0
    spheres: int = 0

    def diffuse(self, name: str, reflectance: Rgb, emission: Rgb | None = None) -> int:
        """Lambert's reflection, and emission [W/m²/sr] from the front: plain glTF says it all."""
        material = _metallic_roughness(name, reflectance, metallic=0.0, roughness=1.0)
        # Without it glTF lays a faint gloss over every non-metal.
        self._extend(material, "KHR_materials_specular", specularFactor=0.0)
        if emission is not None:
            # A power of two as strength keeps the product of the two as exact as each.
            strength = max(1.0, 2.0 ** math.ceil(math.log2(max(emission))))
            material["emissiveFactor"] = [_number(e / strength) for e in emission]
            if strength != 1.0:
                self._extend(material, "KHR_materials_emissive_strength", emissiveStrength=strength)
        return self._material(material)

    def conductor(self, name: str, tint: Rgb, alpha: float = 0.0) -> int:
        """A metal that reflects the share `tint` at every angle: GGX, or a mirror at α = 0."""
        # glTF squares its roughness to get α.
        material = _metallic_roughness(name, tint, metallic=1.0, roughness=math.sqrt(alpha))
        bsdf: Json = {"type": "rough_conductor", "alpha": alpha} if alpha else {"type": "conductor"}
        bsdf["fresnel"] = {"specular_tint": list(tint)}
        material["extras"] = {"pathspace": {"bsdf": bsdf}}
        return self._material(material)

    def dielectric(self, name: str, interior_ior: float) -> int:
        """Smooth clear glass in air."""
        material = _metallic_roughness(name, (1.0, 1.0, 1.0), metallic=0.0, roughness=0.0)
        self._extend(material, "KHR_materials_transmission", transmissionFactor=1.0)
        self._extend(material, "KHR_materials_ior", ior=interior_ior)
        bsdf = {"type": "dielectric", "interior_ior": interior_ior}
        material["extras"] = {"pathspace": {"bsdf": bsdf}}
        return self._material(material)

    def mesh(self, name: str, shape: Shape, material: int) -> None:
        """A triangle mesh with flat faces."""
        self.triangles += len(shape.triangles)
        self.nodes.append({"name": name, "mesh": self._mesh(name, shape, material)})

    def sphere(self, name: str, centre: Vec3, radius: float, material: int) -> None:
        """An exact sphere, with triangles beside it for viewers that know only those."""
        self.spheres += 1
        unit = icosphere(2)
        shape = Shape([(radius * x, radius * y, radius * z) for x, y, z in unit.vertices])
        shape.triangles = unit.triangles
        self.nodes.append(
            {
                "name": name,
                "mesh": self._mesh(name, shape, material, normals=unit.vertices),
                "translation": [_number(c) for c in centre],
                "extras": {"pathspace": {"sphere": {"radius": radius}}},
            }
        )

    def camera(self, position: Vec3, target: Vec3, vertical_fov: float) -> None:
        """A pinhole camera with Y up in its image; the angle is in radians."""
        film = self.settings["film"]
        perspective = {
            "aspectRatio": _number(film["width"] / film["height"]),
            "yfov": _number(vertical_fov),
            "znear": 0.01,
        }
        self.cameras.append({"type": "perspective", "name": "camera", "perspective": perspective})
        self.nodes.append(
            {
                "name": "camera",
                "camera": len(self.cameras) - 1,
                "translation": [_number(p) for p in position],
                "rotation": [_number(q) for q in look_along(sub(target, position))],
            }
        )

    def files(self) -> dict[str, bytes]:
        """The content of each file of the scene, by name."""
        self.vertices += bytes(-len(self.vertices) % 4)
        views = [
            {"buffer": 0, "byteLength": len(self.vertices), "byteStride": 12},
            {"buffer": 0, "byteOffset": len(self.vertices), "byteLength": len(self.indices)},
        ]
        views[0]["target"], views[1]["target"] = ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER
        binary = bytes(self.vertices + self.indices)
        document: Json = {
            "asset": {"version": "2.0", "generator": "pathspace, scenes/generate.py"},
            "extensionsUsed": sorted(self.extensions),
            "scene": 0,
            "scenes": [
                {
                    "name": self.name,
                    "nodes": list(range(len(self.nodes))),
                    "extras": {"pathspace": self.settings},
                }
            ],
            "nodes": self.nodes,
            "cameras": self.cameras,
            "materials": self.materials,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": views,
            "buffers": [{"uri": "scene.bin", "byteLength": len(binary)}],
        }
        if not self.extensions:
            del document["extensionsUsed"]
        text = json.dumps(document, indent=2, ensure_ascii=False)
        # Vectors and the smallest objects stand on one line, for short diffs.
        text = re.sub(r"[\[{]\s+([^\[\]{}]{1,90}?)\s+[\]}]", _on_one_line, text)
        return {"scene.gltf": f"{text}\n".encode(), "scene.bin": binary}

    def _material(self, material: Json) -> int:
        self.materials.append(material)
        return len(self.materials) - 1

    def _extend(self, material: Json, extension: str, **values: float) -> None:
        self.extensions.add(extension)
        material.setdefault("extensions", {})[extension] = values

    def _mesh(
        self, name: str, shape: Shape, material: int, normals: list[Vec3] | None = None
    ) -> int:
        attributes = {"POSITION": self._vectors(shape.vertices, bounds=True)}
        if normals is not None:
            attributes["NORMAL"] = self._vectors(normals, bounds=False)
        offset, count = len(self.indices), 3 * len(shape.triangles)
        for triangle in shape.triangles:
            self.indices += struct.pack("<3H", *triangle)
        view = {"bufferView": 1, "byteOffset": offset}
        kind = {"componentType": UNSIGNED_SHORT, "count": count, "type": "SCALAR"}
        self.accessors.append(view | kind)
        primitive = {"attributes": attributes, "indices": len(self.accessors) - 1}
        self.meshes.append({"name": name, "primitives": [primitive | {"material": material}]})
        return len(self.meshes) - 1

    def _vectors(self, vectors: list[Vec3], *, bounds: bool) -> int:
        packed = [struct.pack("<3f", *v) for v in vectors]
        accessor: Json = {"bufferView": 0, "byteOffset": len(self.vertices)}
        accessor |= {"componentType": FLOAT, "count": len(vectors), "type": "VEC3"}
        if bounds:
            stored = [struct.unpack("<3f", p) for p in packed]
            accessor["min"] = [min(column) for column in zip(*stored, strict=True)]
            accessor["max"] = [max(column) for column in zip(*stored, strict=True)]
        self.vertices += b"".join(packed)
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _metallic_roughness(name: str, color: Rgb, *, metallic: float, roughness: float) -> Json:
    values: Json = {"baseColorFactor": [*color, 1.0]}
    values |= {"metallicFactor": metallic, "roughnessFactor": _number(roughness)}
    return {"name": name, "pbrMetallicRoughness": values}


def _number(value: float) -> float:
    return float(f"{value:.12g}") + 0.0


def _on_one_line(match: re.Match[str]) -> str:
    text = match.group(0)
    inside = re.sub(r"\s*\n\s*", " ", match.group(1))
    return text[0] + inside + text[-1]
