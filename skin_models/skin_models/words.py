"""Words that sentences share."""


def counted(count: int, noun: str) -> str:
    """`3 samples`, `1 sample`."""
    return f"{int(count)} {noun}" + ("" if count == 1 else "s")
