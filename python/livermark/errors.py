"""What the functions of livermark raise."""


class InputError(ValueError):
    """What was given is wrong: the sentence says what, where and the remedy."""


class DivergedError(ArithmeticError):
    """A motion is not finite any more: the sentence says since when, and the remedy."""
