"""Contact, which is not converted: what to write for it."""


def hint(pairs):
    """The section of the input for pairs of surfaces: (name, name or "" for a surface that touches itself, coefficient of friction or None)."""
    listed = ", ".join("{" + f"surface: {surface}" + (f", with: {other}" if other else "") + (f", friction: {friction:g}" if friction else "") + "}"
                       for surface, other, friction in pairs)
    return ("contact is not converted; write it in the input, with law: barrier or penalty: "
            f"`contact: {{law: barrier, pairs: {f'[{listed}]' if pairs else 'all'}}}`")
