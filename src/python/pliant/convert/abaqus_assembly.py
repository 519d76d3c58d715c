"""Assemblies of several instances in an input file of Abaqus: each gets the cards of its part."""


def has_several_instances(cards):
    """Whether there are several, or one of several parts."""
    return any(card.keyword == "INSTANCE" for card in cards) and sum(card.keyword in ("INSTANCE", "PART") for card in cards) > 2


def assembled(cards, diagnostics):
    """The cards with those of a part in each of its instances, and not where the part is defined."""
    parts, rest, part = {}, [], None
    for card in cards:
        if card.keyword == "PART":
            part = card.upper("NAME")
            if part in parts:
                raise diagnostics.wrong(card.line, f"a second part has the name '{card.value('NAME')}'")
            parts[part] = []
        elif card.keyword == "ENDPART":
            part = None
        elif part is not None:
            parts[part].append(card)
        else:
            rest.append(card)
    result = []
    for card in rest:
        result.append(card)
        if card.keyword == "INSTANCE":
            if card.upper("PART") not in parts:
                raise diagnostics.undefined(card.line, f"the part '{card.value('PART')}' of the instance '{card.value('NAME')}' is not defined", card.value("PART"), parts)
            result += parts[card.upper("PART")]
    return result
