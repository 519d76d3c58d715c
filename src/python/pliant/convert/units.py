"""Systems of units, as FEBio names them, and the factors from them to SI."""

# kilogram, metre and second of the system in SI
SYSTEMS = {"SI": (1, 1, 1), "mm-N-s": (1e3, 1e-3, 1), "mm-kg-s": (1, 1e-3, 1), "mm-g-s": (1e-3, 1e-3, 1), "mm-mg-s": (1e-6, 1e-3, 1),
           "mm-kg-ms": (1, 1e-3, 1e-3), "um-nN-s": (1e-3, 1e-6, 1), "CGS": (1e-3, 1e-2, 1)}


def factor(system, dimension):
    result = 1.0
    for base, exponent in zip(SYSTEMS[system], dimension):
        result *= float(base) ** exponent
    return result
