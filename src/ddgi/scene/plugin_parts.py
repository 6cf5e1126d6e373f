"""What a built Mitsuba plugin is made of: its nested plugins by name.

Works on any object, whether it came from a file, a dictionary, or was built by the caller.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi


def parts(plugin: Any) -> dict[str, Any]:
    """Nested plugins by parameter name, such as `reflectance` of a diffuse BSDF."""

    # Mitsuba passes traversal callbacks by Python inheritance, and its base class needs a variant.
    class Collector(mi.TraversalCallback):
        def __init__(self) -> None:
            super().__init__()
            self.found: dict[str, Any] = {}

        def put(self, name: str, value: Any, *_: Any) -> None:
            if isinstance(value, mi.Object):
                self.found[name] = value

        def put_object(self, name: str, value: Any, *_: Any) -> None:
            self.put(name, value)

        def put_value(self, *_: Any) -> None:
            pass

    collector = Collector()
    plugin.traverse(collector)
    return collector.found
