"""Errors meant for people: what was wrong, where, and what to do."""


class DDGIError(Exception):
    """Base of every error this package raises on purpose; its text is one readable line."""


class BackendError(DDGIError):
    """No usable compute backend: LLVM or OptiX is missing or too old."""


class SceneError(DDGIError):
    """A scene file, or something it refers to, cannot be used."""


class SettingsError(DDGIError):
    """A setting is unknown, of the wrong kind or out of its range."""


class OutputError(DDGIError):
    """A result cannot be written where it was asked for."""
