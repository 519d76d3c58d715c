"""An XML file as a tree that knows its lines, and what of it was used."""
import xml.parsers.expat

from pliant.error import PliantError


class Node:
    """An element; `used`: whether something was made of it, or it was listed as left out."""

    def __init__(self, tag, attributes, line):
        self.tag, self.attributes, self.line = tag, attributes, line
        self.children, self.texts, self.used = [], [], False

    def get(self, name, default=""):
        return self.attributes.get(name, default)

    @property
    def text(self):
        return "".join(self.texts).strip()

    def child(self, tag):
        """The first one with this tag, which counts as used; or None."""
        for child in self.children:
            if child.tag == tag:
                child.used = self.used = True
                return child
        return None

    def each(self, tag):
        """All with this tag; they count as used."""
        for child in self.children:
            if child.tag == tag:
                child.used = self.used = True
                yield child

    def use(self):
        """The element with all that is in it."""
        self.used = True
        for child in self.children:
            child.use()
        return self

    def unused(self):
        """The outermost elements that nothing was made of."""
        for child in self.children:
            if child.used:
                yield from child.unused()
            else:
                yield child


def read_tree(file):
    """The root. Raises PliantError for a file that is not XML."""
    parser = xml.parsers.expat.ParserCreate()
    parser.buffer_text = True
    root = Node("", {}, 0)
    open_nodes = [root]

    def begin(tag, attributes):
        node = Node(tag, attributes, parser.CurrentLineNumber)
        open_nodes[-1].children.append(node)
        open_nodes.append(node)

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda _: open_nodes.pop()
    parser.CharacterDataHandler = lambda text: open_nodes[-1].texts.append(text)
    try:
        with open(file, "rb") as data:
            parser.ParseFile(data)
    except OSError as error:
        raise PliantError(f"{file}: {error.strerror}") from None
    except xml.parsers.expat.ExpatError as error:
        raise PliantError(f"{file}:{error.lineno}: not an XML file: {xml.parsers.expat.ErrorString(error.code)}") from None
    return root.children[0]
