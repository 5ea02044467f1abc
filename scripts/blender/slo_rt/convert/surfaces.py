# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials of a scene and their textures, as elements and files."""

import os

from ..format.names import Names
from ..format.phong import BLACK
from ..format.scene_text import Element
from . import material, physical
from .image import Original, Picture
from .image_use import multiplies_alpha
from .things import Look

# Notes on images that were written, by the names of their files.
_notes_of_images = {}


class Surfaces:
    """The materials of things, as Phong values. Each is read when it is first requested.

    `now(item)` returns an item of Blender's data with the values of the frame. Textures go to
    `folder`, named by a hash of their contents if `by_content`. `ambient_light` is the light of the
    world.
    """

    def __init__(self, now, ambient_light, folder, by_content, report):
        self._now = now
        self._ambient_light = ambient_light
        self._folder = folder
        self._by_content = by_content
        self._report = report
        self._finishes = {}
        self._textures = {}
        self._names = {kind: Names() for kind in ("material", "texture", "file")}

    def _finish(self, item):
        """Returns the name in the scene and the finish (or None) of a `bpy` material or None."""
        key = item.name_full if item else None
        if key not in self._finishes:
            name = self._names["material"].new(item.name if item else "no_material")
            self._finishes[key] = name, self._read(self._now(item))
        return self._finishes[key]

    def _read(self, item):
        return material.finish(item, self._ambient_light, self._report)

    def name_of(self, item):
        """Returns the name in the scene of a `bpy` material or None."""
        return self._finish(item)[0]

    def look_of(self, item):
        """Returns the `Look` of a `bpy` material or None; None if its objects are invisible."""
        finish = self._finish(item)[1]
        return None if finish is None else self._look(finish)

    def _look(self, finish):
        if finish.texture:
            return Look(finish.texture.uv_map, True)
        # A texture may be added to an export by hand.
        return Look(None if self._by_content else "", False)

    def emits(self, item):
        """Whether objects of a `bpy` material or None are lamps."""
        del item
        return False

    def elements(self, things):
        """Returns the elements of all materials of `things`, and writes their textures."""
        elements = []
        used = {
            part.material.name_full if part.material else None for t in things for part in t.parts
        }
        for key, (name, finish) in self._finishes.items():
            if key in used:
                self._add_elements(name, finish, elements)
        order = {"texture": 0, "phong_info": 1}
        return sorted(elements, key=lambda element: order.get(element.kind, 2))

    def _add_elements(self, name, finish, elements):
        elements.append(finish.phong.element(name))
        texture = self._texture(finish.texture, elements) if finish.texture else None
        body = [("phong_info", name)]
        if texture:
            scale = finish.texture.scale
            body += [("texture", texture), ("scale_U", scale[0]), ("scale_V", scale[1])]
        kind = "material_texture" if texture else "material_phong"
        elements.append(Element(kind, name, body))

    def _texture(self, texture, elements):
        """Returns the name of the texture's element, which is written when it is first needed; None if
        the image is unreadable."""
        picture, key = texture.image, (texture.image.name_full, texture.is_alpha)
        if key not in self._textures:
            wish = os.path.splitext(picture.name)[0] + ("_alpha" if texture.is_alpha else "")
            name = self._names["texture"].new(wish)
            filename = self._store_image(Picture(picture, texture.is_alpha), name)
            self._textures[key] = name if filename else None
            if filename:
                elements.append(Element("texture", name, [("filename", filename)]))
        return self._textures[key]

    def _store_image(self, picture, name):
        """Writes an image unless it exists. Returns its path in the scene, or None if there is no image."""
        if picture.image.source in {"MOVIE", "SEQUENCE", "TILED"}:
            self._report.note(
                picture.subject, "of movies, sequences and tiles only the first picture is carried"
            )
        if not picture.is_readable:
            self._report.note(picture.subject, "can't be read; its surface has no texture")
            return None
        name = picture.digest() if self._by_content else name
        name = f"{name}.{picture.ending}"
        path = os.path.join(self._folder, name)
        if not (self._by_content and name in _notes_of_images and os.path.exists(path)):
            _notes_of_images[name] = picture.write(path)
        for note in _notes_of_images[name]:
            self._report.note(picture.subject, note)
        return f"{os.path.basename(self._folder)}/{name}"


class PhysicalSurfaces(Surfaces):
    """The materials of things, as physical surfaces, unless the artist has entered Phong values."""

    def __init__(self, now, folder, by_content, report):
        super().__init__(now, BLACK, folder, by_content, report)
        self._files = {}

    def _read(self, item):
        if item is not None and item.slo_rt.use_own:
            return super()._read(item)
        return physical.surface_of(item, self._report)

    def _look(self, finish):
        if isinstance(finish, material.Finish):
            return super()._look(finish)
        maps = list(dict.fromkeys(use.texture.uv_map for use in finish.uses()))
        if maps:
            return Look(maps[0], True)
        # An image may be added to an export by hand.
        return Look(None if self._by_content and not finish.is_brushed else "", False)

    def emits(self, item):
        finish = self._finish(item)[1]
        return not isinstance(finish, material.Finish | None) and finish.emits

    def _add_elements(self, name, finish, elements):
        if isinstance(finish, material.Finish):
            super()._add_elements(name, finish, elements)
            return
        maps = {use.texture.uv_map for use in finish.uses()}
        if len(maps) > 1:
            self._report.note(
                f'material "{name}"', "all its images use one uv map, that of the first of them"
            )

        def name_of(sampled):
            return self.texture_of(sampled, elements)

        elements += finish.elements(name, self._names["material"].new, name_of)

    def texture_of(self, sampled, elements):
        """Returns the name of the element of a `Sampled`, which is added to `elements` when it is first
        needed."""
        image = sampled.image
        key = image.name_full, sampled.has_alpha, sampled.wrap, sampled.filter
        if key not in self._textures:
            filename, encoding = self._file_of(sampled)
            name = self._names["texture"].new(os.path.splitext(image.name)[0])
            body = [("filename", filename), ("encoding", encoding)]
            body += [] if sampled.wrap == "REPEAT" else [("wrap", sampled.wrap)]
            body += [] if sampled.filter == "LINEAR" else [("filter", sampled.filter)]
            elements.append(Element("texture", name, body))
            self._textures[key] = name
        return self._textures[key]

    def _file_of(self, sampled):
        """Returns the path in the scene and the encoding of an image's file, which is written once."""
        image = sampled.image
        key = image.name_full, sampled.has_alpha
        if key not in self._files:
            picture = Original(image, sampled.has_alpha, multiplies_alpha(image))
            wish = os.path.splitext(image.name)[0] + ("_alpha" if sampled.has_alpha else "")
            path = self._store_image(picture, self._names["file"].new(wish))
            self._files[key] = path, picture.encoding
        return self._files[key]
