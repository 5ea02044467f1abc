# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes in which things bend, hang together and come often: a walker, a flag, a forest."""

import math

import bpy
import numpy as np

# Bones: head, tail, parent, radius. The walker looks along -y and is 1.8 m high.
BONES = {
    "hips": ((0, 0, 0.95), (0, 0, 1.1), None, 0.13),
    "spine": ((0, 0, 1.1), (0, 0, 1.5), "hips", 0.15),
    "head": ((0, 0, 1.55), (0, 0, 1.8), "spine", 0.11),
    **{
        f"{name}.{side}": (
            (x * sign, 0, a),
            (x * sign, y, b),
            f"{parent}.{side}" if parent in {"thigh", "arm"} else parent,
            radius,
        )
        for side, sign in (("L", 1), ("R", -1))
        for name, x, y, a, b, parent, radius in (
            ("thigh", 0.11, -0.02, 0.95, 0.5, "hips", 0.085),
            ("shin", 0.11, 0.0, 0.5, 0.08, "thigh", 0.06),
            ("arm", 0.22, 0.02, 1.45, 1.15, "spine", 0.05),
            ("forearm", 0.22, -0.03, 1.15, 0.85, "arm", 0.04),
        )
    },
}
RINGS, SECTORS = 7, 12


def walker():
    """A figure of tubes around the bones of an armature, smoothly weighted, in the middle of a stride."""
    armature = bpy.data.armatures.new("Skeleton")
    rig = bpy.data.objects.new("Skeleton", armature)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail, parent, _) in BONES.items():
        bone = armature.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        bone.parent = armature.edit_bones[parent] if parent else None
    bpy.ops.object.mode_set(mode="OBJECT")
    body = _body(rig)
    for bone in rig.pose.bones:
        bone.rotation_mode = "XYZ"
    for frame in range(1, 26, 3):
        _pose(rig, frame)
    return rig, body


def _body(rig):
    vertices, faces = [], []
    for head, tail, _, radius in BONES.values():
        _tube(np.array(head, float), np.array(tail, float), radius, vertices, faces)
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata(vertices, [], faces)
    body = bpy.data.objects.new("Body", mesh)
    bpy.context.scene.collection.objects.link(body)
    body.parent = rig
    body.modifiers.new("Armature", "ARMATURE").object = rig
    subdivision = body.modifiers.new("Smooth", "SUBSURF")
    subdivision.levels = subdivision.render_levels = 1
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    _weigh(body, np.array(vertices))
    return body


def _tube(head, tail, radius, vertices, faces):
    start, along = len(vertices), tail - head
    length = np.linalg.norm(along)
    across = np.cross(along / length, (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    other = np.cross(along / length, across)
    for ring in range(RINGS):
        u = ring / (RINGS - 1)
        thick = radius * (0.55 + 0.45 * math.sin(math.pi * u))
        for sector in range(SECTORS):
            angle = 2.0 * math.pi * sector / SECTORS
            side = math.cos(angle) * across + math.sin(angle) * other
            vertices.append(tuple(head + along * u + side * thick))
    for ring in range(RINGS - 1):
        for sector in range(SECTORS):
            a, b = start + ring * SECTORS + sector, start + ring * SECTORS + (sector + 1) % SECTORS
            faces.append((a, b, b + SECTORS, a + SECTORS))
    faces.append(tuple(start + sector for sector in reversed(range(SECTORS))))
    faces.append(tuple(start + (RINGS - 1) * SECTORS + sector for sector in range(SECTORS)))


def _weigh(body, vertices):
    """Each vertex follows all bones, the nearest ones most."""
    weights = []
    for head, tail, _, _ in BONES.values():
        head, along = np.array(head, float), np.subtract(tail, head)
        u = np.clip((vertices - head) @ along / (along @ along), 0.0, 1.0)
        gap = np.linalg.norm(vertices - head - u[:, None] * along, axis=1)
        weights.append(np.exp(-((gap / 0.07) ** 2)))
    weights = np.array(weights)
    weights /= weights.sum(axis=0)
    for name, own in zip(BONES, weights):
        group = body.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(own > 0.01):
            group.add([int(vertex)], float(own[vertex]), "REPLACE")


def _pose(rig, frame):
    phase = 2.0 * math.pi * frame / 12.0
    bones = rig.pose.bones
    for side, shift in (("L", 0.0), ("R", math.pi)):
        swing = math.sin(phase + shift)
        turns = {
            "thigh": 0.7 * swing,
            "shin": -0.9 * max(0.0, math.cos(phase + shift)),
            "arm": -0.6 * swing,
            "forearm": 0.5 + 0.3 * swing,
        }
        for name, turn in turns.items():
            bone = bones[f"{name}.{side}"]
            bone.rotation_euler.x = turn
            bone.keyframe_insert("rotation_euler", frame=frame)
    bones["spine"].rotation_euler.y = 0.25 * math.sin(phase)
    bones["spine"].keyframe_insert("rotation_euler", frame=frame)
    rig.location = (-0.12 * (frame - 13), 0.0, 0.04 * math.cos(2.0 * phase))
    rig.rotation_euler.z = -math.pi / 2.0
    rig.keyframe_insert("location", frame=frame)
    rig.keyframe_insert("rotation_euler", frame=frame)


def flag():
    """A flag of cloth with a pole, in quick waves, that is hoisted by shape keys."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=48, y_subdivisions=32, size=1.0)
    cloth = bpy.context.object
    cloth.name = "Flag"
    for vertex in cloth.data.vertices:
        vertex.co.x = 2.4 * (vertex.co.x + 0.5)
        vertex.co.z, vertex.co.y = 1.5 * vertex.co.y, 0.0
    cloth.shape_key_add(name="Basis")
    hoisted = cloth.shape_key_add(name="Hoisted")
    for point in hoisted.data:
        point.co.z += 1.2 - 0.2 * point.co.x**2
    for frame, value in ((1, 0.0), (5, 0.0), (9, 1.0), (12, 0.2)):
        hoisted.value = value
        hoisted.keyframe_insert("value", frame=frame)
    wave = cloth.modifiers.new("Wave", "WAVE")
    wave.use_x, wave.use_y, wave.use_normal = True, False, True
    wave.height, wave.width, wave.narrowness, wave.speed = 0.35, 0.9, 1.6, 0.3
    cloth.rotation_euler.z = 0.6
    for polygon in cloth.data.polygons:
        polygon.use_smooth = True
    bpy.ops.mesh.primitive_cylinder_add(radius=0.05, depth=3.6, location=(0.0, 0.0, -0.3))
    bpy.context.object.name = "Pole"
    return cloth


def trees():
    """A hidden collection with a tree of two objects."""
    collection = bpy.data.collections.new("Tree")
    bpy.ops.mesh.primitive_cylinder_add(
        radius=0.06, depth=0.6, location=(0.0, 0.0, 0.3), vertices=8
    )
    trunk = bpy.context.object
    bpy.ops.mesh.primitive_cone_add(radius1=0.3, depth=0.9, location=(0.0, 0.0, 0.95), vertices=9)
    crown = bpy.context.object
    for thing, name in ((trunk, "Trunk"), (crown, "Crown")):
        thing.name = name
        for other in list(thing.users_collection):
            other.objects.unlink(thing)
        collection.objects.link(thing)
    return collection


def grove(collection, count, density=12.0):
    """A ground whose geometry nodes put trees on it, turned and scaled at random."""
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    new, links = tree.nodes.new, tree.links
    start, end = new("NodeGroupInput"), new("NodeGroupOutput")
    points, put = new("GeometryNodeDistributePointsOnFaces"), new("GeometryNodeInstanceOnPoints")
    source, join = new("GeometryNodeCollectionInfo"), new("GeometryNodeJoinGeometry")
    source.inputs["Collection"].default_value = collection
    points.inputs["Density"].default_value = density
    turn, size = new("FunctionNodeRandomValue"), new("FunctionNodeRandomValue")
    turn.data_type = "FLOAT_VECTOR"
    turn.inputs["Max"].default_value = (0.3, 0.3, 6.0)
    sizes = [socket for socket in size.inputs if socket.type == "VALUE" and socket.enabled]
    sizes[0].default_value, sizes[1].default_value = 0.5, 1.1
    links.new(start.outputs[0], points.inputs["Mesh"])
    links.new(points.outputs["Points"], put.inputs["Points"])
    links.new(source.outputs[0], put.inputs["Instance"])
    links.new(turn.outputs["Value"], put.inputs["Rotation"])
    links.new(next(s for s in size.outputs if s.type == "VALUE" and s.enabled), put.inputs["Scale"])
    links.new(put.outputs[0], join.inputs[0])
    links.new(start.outputs[0], join.inputs[0])
    links.new(join.outputs[0], end.inputs[0])
    bpy.ops.mesh.primitive_plane_add(size=count)
    ground = bpy.context.object
    ground.name = "Ground"
    ground.modifiers.new("Scatter", "NODES").node_group = tree
    return ground


def collection_instance(collection, name, location):
    """An empty that shows a collection."""
    empty = bpy.data.objects.new(name, None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    empty.location = location
    bpy.context.scene.collection.objects.link(empty)
    return empty
