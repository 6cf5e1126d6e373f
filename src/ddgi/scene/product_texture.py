"""A texture plugin that multiplies two: a picture, and what the vertices of the mesh say.

In a description: {"type": "ddgi_product", "picture": {...}, "tint": {...}}. Mitsuba has none of its own.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

PLUGIN = "ddgi_product"


def register_product() -> None:
    """Make the plugin known to Mitsuba's variant in use; once more does no harm."""

    # Mitsuba's base class needs a variant.
    class Product(mi.Texture):
        def __init__(self, properties: Any) -> None:
            super().__init__(properties)
            self.picture, self.tint = properties["picture"], properties["tint"]

        def traverse(self, callback: Any) -> None:
            callback.put("picture", self.picture, mi.ParamFlags.Differentiable)
            callback.put("tint", self.tint, mi.ParamFlags.Differentiable)

        def eval(self, si: Any, active: Any = True) -> Any:
            return self.picture.eval(si, active) * self.tint.eval(si, active)

        def eval_1(self, si: Any, active: Any = True) -> Any:
            return self.picture.eval_1(si, active) * self.tint.eval_1(si, active)

        def eval_3(self, si: Any, active: Any = True) -> Any:
            return self.picture.eval_3(si, active) * self.tint.eval_3(si, active)

        def mean(self) -> Any:
            return self.picture.mean()

        def is_spatially_varying(self) -> bool:
            return True

        def to_string(self) -> str:
            return f"Product[picture = {self.picture}, tint = {self.tint}]"

    mi.register_texture(PLUGIN, Product)
