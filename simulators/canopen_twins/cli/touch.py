"""inject, clear, set, get, power, state, watch: hands on a twin that runs, by its control port."""

import argparse
import json
from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import urlencode

from canopen_twins.cli.command import OK, Parser, add_json
from canopen_twins.errors import UserError
from canopen_twins.live.remote import RemotePort, RemoteTwin, twin_of
from canopen_twins.live.running import all_running

ALL = "all"


def add_port(parser: Parser) -> None:
    """Which twin is meant."""
    text = "where its control port is, as the ready line of `run --control` tells it (default: the"
    parser.add_argument("--at", metavar="ADDRESS", help=f"{text} only one of yours that runs)")
    parser.add_argument("--token", metavar="TOKEN", default="", help="that of --control-token")
    text = "its name or its node id, if there are several on the bus"
    parser.add_argument("--node", metavar="NAME", help=text)


def port_of(options: argparse.Namespace) -> RemotePort:
    """The port that the options mean.

    Raises:
        UserError: none of this user runs, or several do.
    """
    if options.at:
        return RemotePort(options.at, options.token)
    running = all_running()
    if len(running) == 1:
        return RemotePort(running[0].address, options.token or running[0].token)
    if not running:
        raise UserError("no twin of yours runs with --control: start one, or say --at HOST:PORT")
    told = ", ".join(f"{each.title} at {each.address}" for each in running)
    raise UserError(f"several run, say which with --at: {told}")


def chosen(options: argparse.Namespace) -> RemoteTwin:
    """The node that the options mean; raises as `port_of` and `connect` do."""
    try:
        return twin_of(port_of(options), options.node)
    except UserError as refusal:
        if str(refusal).endswith("say which node"):
            raise UserError(f"{refusal} with --node") from None
        raise


def pairs(words: Sequence[str]) -> Mapping[str, str]:
    """KEY=VALUE, as with --set; raises `UserError` for something else."""
    found: dict[str, str] = {}
    for word in words:
        key, equals, found[key] = word.partition("=")
        if not equals:
            raise UserError(f"{word}: write it as KEY=VALUE")
    return found


def add_inject(parser: Parser) -> None:
    """inject."""
    parser.add_argument("fault", metavar="FAULT", help="one of `canopen-twin faults`")
    text = "its parameters"
    parser.add_argument("parameters", nargs="*", default=[], metavar="KEY=VALUE", help=text)
    add_port(parser)
    parser.set_defaults(command=inject)


def inject(options: argparse.Namespace) -> int:
    """Say at which moment it took effect, as JSON."""
    return _told(chosen(options), "inject", options.fault, pairs(options.parameters))


def add_clear(parser: Parser) -> None:
    """clear."""
    text = f"one that is active (default: {ALL})"
    parser.add_argument("fault", metavar="FAULT", nargs="?", default=ALL, help=text)
    add_port(parser)
    parser.set_defaults(command=clear)


def clear(options: argparse.Namespace) -> int:
    """As `inject`."""
    return _told(chosen(options), "clear", None if options.fault == ALL else options.fault)


def add_set(parser: Parser) -> None:
    """set."""
    text = "a setting, or an object of a device that a file describes"
    parser.add_argument("settings", nargs="+", metavar="KEY=VALUE", help=text)
    add_port(parser)
    parser.set_defaults(command=set_live)


def set_live(options: argparse.Namespace) -> int:
    """As `inject`."""
    return _told(chosen(options), "set", pairs(options.settings))


def add_power(parser: Parser) -> None:
    """power."""
    parser.add_argument("switch", choices=("on", "off"))
    text = "settings to be switched on with"
    parser.add_argument("settings", nargs="*", default=[], metavar="KEY=VALUE", help=text)
    add_port(parser)
    parser.set_defaults(command=power)


def power(options: argparse.Namespace) -> int:
    """As `inject`."""
    if options.switch == "on":
        return _told(chosen(options), "power_on", pairs(options.settings))
    if options.settings:
        raise UserError("settings are taken over when the power comes, not when it goes")
    return _told(chosen(options), "power_off")


def _told(twin: RemoteTwin, word: str, *arguments: Any) -> int:
    print(json.dumps({"node": twin.name, "moment": twin.moment_of(word, *arguments)}))
    return OK


def add_get(parser: Parser) -> None:
    """get."""
    text = "an object by its name or address (default: all that can be read)"
    parser.add_argument("names", nargs="*", default=[], metavar="OBJECT", help=text)
    add_json(parser)
    add_port(parser)
    parser.set_defaults(command=get)


def get(options: argparse.Namespace) -> int:
    """One value alone, or each with its name."""
    values = chosen(options).values(*options.names)
    if options.json:
        print(json.dumps(values, indent=2))
    elif len(options.names) == 1:
        print(*values.values())
    else:
        _lines(values)
    return OK


def add_state(parser: Parser) -> None:
    """state."""
    add_json(parser)
    add_port(parser)
    parser.set_defaults(command=state)


def state(options: argparse.Namespace) -> int:
    """How the node is, or without --node every node."""
    port = port_of(options)
    names = [each["name"] for each in port.call("GET", "/nodes")]
    wanted = [twin_of(port, options.node)] if options.node else [RemoteTwin(port, n) for n in names]
    told = [twin.state_now for twin in wanted]
    if options.json:
        print(json.dumps(told, indent=2))
        return OK
    for each in told:
        supply = each["state"] if each["powered"] else "power off"
        print(f"{each['name']}: node {each['node_id']}, {supply}")
        faults = ", ".join(fault["words"] for fault in each["faults"])
        errors = ", ".join(f"{e['code']:04X}h {e['label']}".strip() for e in each["errors"])
        lines = {"faults": faults or "none", "EMCY": errors or "none", **each["report"]}
        _lines({f"  {key}": value for key, value in lines.items()})
    return OK


def _lines(values: Mapping[str, object]) -> None:
    for name, value in values.items():
        print(f"{name}: {value}")


def add_watch(parser: Parser) -> None:
    """watch."""
    text = "only these: frame, emcy, state, order, step, inject, clear, outcome, note"
    parser.add_argument("--kind", action="append", default=[], metavar="KIND", help=text)
    parser.add_argument("--json", action="store_true", help="an object a line, for programs")
    add_port(parser)
    parser.set_defaults(command=watch)


def watch(options: argparse.Namespace) -> int:
    """A line for each event until the twins end, or SIGINT."""
    port = port_of(options)
    node = [("node", options.node)] if options.node else []
    query = urlencode([*(("kind", kind) for kind in options.kind), *node])
    for event in port.events(f"/events?{query}"):
        print(json.dumps(event) if options.json else event_line(event), flush=True)
    return OK


def event_line(event: Mapping[str, Any]) -> str:
    """As `last_frames` writes them, with the time of the bus in seconds."""
    said = f"{event['frame']:21}  {event['words']}" if "frame" in event else event["words"]
    kind = "" if "frame" in event else f"{event['kind']}: "
    why = "".join(f"\n{'':26}why: {reason}" for reason in event.get("why", ()))
    return f"{event['moment'] / 1e6:12.6f}  {event['node'] or '-':10}  {kind}{said}{why}".rstrip()
