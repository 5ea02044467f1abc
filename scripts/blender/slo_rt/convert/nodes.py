# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees: the inputs of sockets, and notes on the parts of nodes that are not read.

Links are followed as in Cycles: muted links are ignored, muted nodes pass their inputs on by their
internal links, and reroutes and node groups are followed through.
"""

from dataclasses import dataclass

from .. import compat
from .node_table import PHONG, Entry

# A longer chain of reroutes, groups and muted nodes counts as a circle.
MOST_STEPS = 1000


@dataclass(frozen=True)
class Input:
    """A socket and the group nodes that contain it, outermost first."""

    socket: object
    groups: tuple = ()


@dataclass(frozen=True)
class Feed:
    """The source of an input: the output `socket` of a `node`, or the value of the socket `own`, or 0
    without either."""

    node: object = None
    socket: object = None
    groups: tuple = ()
    own: object = None

    def input(self, name):
        """Returns the input of the node with an identifier or a name, or None."""
        for socket in self.node.inputs:
            if name in (socket.identifier, socket.name) and socket.enabled:
                return Input(socket, self.groups)
        return None

    def inputs(self):
        """Returns all inputs of the node that have an effect."""
        return [Input(socket, self.groups) for socket in self.node.inputs if socket.enabled]


def follow(start):
    """Returns the `Feed` of an `Input`."""
    socket, groups = start.socket, start.groups
    own = socket  # the socket whose value is used if the chain ends without a source
    for _ in range(MOST_STEPS):
        link = _link(socket)
        if link is None:
            dangles = socket != own and compat.ENDLESS_CHAINS_ARE_ZERO
            return Feed(groups=groups, own=None if dangles else own)
        node, output = link.from_node, link.from_socket
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.mute:
            socket = _through(node, output)
            if socket is None:
                return Feed(groups=groups, own=own)
        elif node.type == "GROUP":
            socket = own = _inside(node, output)
            groups = (*groups, node)
            if socket is None:
                return Feed(groups=groups)
        elif node.type == "GROUP_INPUT" and groups:
            socket = own = _by_identifier(groups[-1].inputs, output)
            groups = groups[:-1]
        else:
            return Feed(node, output, groups)
    return Feed()


def _link(socket):
    """Returns the link to a socket that has an effect, or None."""
    for link in socket.links:
        if link.is_valid and not link.is_muted and link.from_socket.enabled and socket.enabled:
            return link
    return None


def _through(node, output):
    """Returns the input that a muted node passes on to `output`, or None."""
    inner = (link for link in node.internal_links if link.to_socket == output)
    return next((link.from_socket for link in inner), None)


def _inside(group, output):
    """Returns the socket in a group's tree that feeds an output of the group, or None."""
    nodes = group.node_tree.nodes if group.node_tree else ()
    ends = [n for n in nodes if n.type == "GROUP_OUTPUT" and n.is_active_output and not n.mute]
    return _by_identifier(ends[0].inputs, output) if ends else None


def _by_identifier(sockets, wanted):
    return next((s for s in sockets if s.identifier == wanted.identifier), None)


def output_node(tree):
    """Returns the output node of a tree that Cycles uses, or None."""
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    if output is not None and output.mute and compat.MUTED_OUTPUTS_ARE_NONE:
        return None
    return output


class Reader:
    """Reads constants of the node trees of one owner, and notes what cannot be read, by a table of
    nodes."""

    def __init__(self, subject, report, table=PHONG):
        self.subject = subject
        self.report = report
        self.table = table

    def note(self, message):
        self.report.note(self.subject, message)

    def constant(self, feed):
        """Returns the number or colour (three numbers) of a feed, or None if it is not constant."""
        return constant(feed)

    def note_rest(self, feed):
        """Notes the parts of a node that have an effect in Blender but not in slo-rt, by its entry in
        the table."""
        node = feed.node
        entry = self.table.entries.get(node.type, Entry())
        for input_ in feed.inputs():
            name = input_.socket.identifier
            if name in entry.read or name in entry.follows:
                continue
            if not self._is_neutral(input_, entry.neutral.get(name, 0.0)):
                self._note_part(node, name, input_.socket.name, "")
        for name, fine in entry.properties.items():
            value = getattr(node, name, None)
            if fine is not None and value is not None and value not in fine:
                self._note_part(node, name, name.replace("_", " "), value)

    def _note_part(self, node, name, label, value):
        value = str(value).lower().replace("_", " ")
        message = self.table.messages.get((node.type, name))
        if message is None:
            message = f"{label} {value}".strip() + " is not carried"
        self.note(message.format(value=value))

    def _is_neutral(self, input_, neutral):
        """Whether an input has no effect: nothing is linked and, if `neutral` is not None, its value is
        `neutral`."""
        feed = follow(input_)
        if feed.node is not None and self.constant(feed) is None:
            return False
        if neutral is None:
            return feed.node is None
        value = _number_or_tuple(self.constant(feed), input_.socket)
        count = len(value) if isinstance(value, tuple) else 1
        wanted = neutral if isinstance(neutral, tuple) else (neutral,) * count
        return value is None or (value if count > 1 else (value,)) == wanted[:count]

    def value(self, input_, otherwise=0.0):
        """Reads a number. Its input is read only if it is constant."""
        if input_ is None:
            return otherwise
        feed = follow(input_)
        found = self.constant(feed)
        if found is None:
            self.note_feed(feed, input_)
            found = constant(Feed(own=input_.socket))
        return luma(found) if isinstance(found, tuple) else found

    def color(self, input_):
        """Reads a colour. Its input is read only if it is constant."""
        feed = follow(input_)
        found = self.constant(feed)
        if found is None:
            self.note_feed(feed, input_)
            found = constant(Feed(own=input_.socket))
        return found if isinstance(found, tuple) else (found,) * 3

    def light(self, color):
        """Reads a colour, clamped to 0 or more, since slo-rt has no negative light."""
        if any(channel < 0.0 for channel in color):
            self.note("negative light and colours are not carried; they are 0")
        return tuple(max(channel, 0.0) for channel in color)

    def unit(self, input_, otherwise=0.0):
        """Reads a number, clamped to [0, 1] as in Cycles."""
        return min(max(self.value(input_, otherwise), 0.0), 1.0)

    def note_feed(self, feed, input_, instead="the socket's own value is"):
        """Notes a link to a socket that cannot be exported."""
        self.note(f"{feed.node.bl_label} on {input_.socket.name} is not carried, {instead}")


def constant(feed):
    """Returns the number or colour (three numbers) of a feed, or None if it is not constant."""
    if feed.node is not None:
        if feed.node.type not in {"VALUE", "RGB"}:
            return None
        feed = Feed(own=feed.socket)
    if feed.own is None:
        return 0.0
    value = getattr(feed.own, "default_value", 0.0)
    return tuple(value)[:3] if hasattr(value, "__len__") and not isinstance(value, str) else value


def nearest(feed, kind):
    """Returns the `Feed` of the nearest node of a type at or behind `feed`, along colours, or None."""
    seen, open_ = set(), [feed]
    while open_:
        feed = open_.pop(0)
        if feed.node is None or (feed.node, feed.groups) in seen:
            continue
        if feed.node.type == kind and feed.node.image:
            return feed
        seen.add((feed.node, feed.groups))
        open_ += [follow(i) for i in feed.inputs() if i.socket.type == "RGBA"]
    return None


def _number_or_tuple(value, socket):
    """Returns a constant as converted by `socket`; None if it is neither number nor colour."""
    if socket.type in {"VALUE", "INT"}:
        return luma(value) if isinstance(value, tuple) else value
    if socket.type in {"RGBA", "VECTOR"}:
        return value if isinstance(value, tuple) else (value,) * 3
    return None


def luma(color):
    """Converts a colour to a number as Blender does."""
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def with_node_trees(owner):
    """`owner` (a material, world, light or scene), its node tree, and all groups in there."""
    found, open_ = [], [owner, getattr(owner, "node_tree", None)]
    while open_:
        tree = open_.pop()
        if tree is None or tree in found:
            continue
        found.append(tree)
        open_ += [getattr(node, "node_tree", None) for node in getattr(tree, "nodes", ())]
    return found
