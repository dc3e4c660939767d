"""Finding a force or contact of a model, and what it remembers."""


def of_kind(model, state, kind):
    """The model's thing of a class, and its memory in a state."""
    (found,) = (
        pair
        for pair in zip(model.interactions, state.memory, strict=True)
        if isinstance(pair[0], kind)
    )
    return found
