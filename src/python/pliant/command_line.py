"""What the command lines of programs in Python share: an error is reported in one line, with the program's exit codes."""
import argparse
import sys

from .error import FILE

WRONG = 2


class Parser(argparse.ArgumentParser):
    def error(self, message):
        sys.exit(report(self.prog, message))


def report(program, message, code=WRONG):
    print(f"{program}: {message}", file=sys.stderr)
    return code


def exit_code(program, work, correctable, output, kinds):
    """Does the work. `correctable` are the exceptions for errors that the user can correct, with their exit codes where they have some;
    `output` is written as one of `kinds`."""
    try:
        work()
    except correctable as error:
        return report(program, error, getattr(error, "code", None) or WRONG)
    except OSError as error:
        return report(program, f"{error.filename}: {error.strerror}" if error.filename else error, FILE)
    except ValueError as error:
        if "is not supported" in str(error) or "unknown file extension" in str(error):
            return report(program, f"{output}: the name must end in one of {kinds}")
        raise
    return 0
