"""What the functions of livermark raise."""


class InputError(ValueError):
    """What was given is wrong: the sentence says what, where and the remedy."""
