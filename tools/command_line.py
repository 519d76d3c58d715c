"""What the command lines of the tools share: a mistake is told in one line, and ends with exit code 2."""
import argparse
import sys


class Parser(argparse.ArgumentParser):
    def error(self, message):
        sys.exit(complain(self.prog, message))


def complain(program, message):
    print(f"{program}: {message}", file=sys.stderr)
    return 2


def exit_code(program, work, mistakes, output, kinds):
    """Does the work. `mistakes` are the errors that tell of what the user can mend; `output` is written as one of `kinds`."""
    try:
        work()
    except mistakes as error:
        return complain(program, error)
    except OSError as error:
        return complain(program, f"{error.filename}: {error.strerror}" if error.filename else error)
    except ValueError as error:
        if "is not supported" in str(error) or "unknown file extension" in str(error):
            return complain(program, f"{output}: the name must end in one of {kinds}")
        raise
    return 0
