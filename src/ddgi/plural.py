"""Numbers in words."""


def counted(number: int, thing: str) -> str:
    """`1 frame`, `2 frames`."""
    return f"{number:,} {thing}" + ("" if number == 1 else "s")


def percent(share: float) -> str:
    """`58 %` of 0.58."""
    return f"{100 * share:.0f} %"
