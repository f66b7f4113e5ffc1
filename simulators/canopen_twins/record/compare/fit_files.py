"""What a fit has found, as files: a bench file, and a device file for the twin of an EDS."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from os.path import relpath
from pathlib import Path
from typing import Any

import yaml
from canopen import ObjectDictionary

from canopen_twins import devices
from canopen_twins.bus.clock import MICROSECONDS
from canopen_twins.bus.sdo import Address
from canopen_twins.device.dcf import dcf
from canopen_twins.device.device import Device
from canopen_twins.errors import UserError
from canopen_twins.files.whole import write_whole
from canopen_twins.record.compare.fit import Specs
from canopen_twins.record.compare.shown import Shown
from canopen_twins.scenario.scenario import NodeSpec
from canopen_twins.slave.dictionary import address_text
from canopen_twins.slave.object import entries_of

APPLICATION = 0x2000
NOTE = "Fitted to a trace by canopen-twin compare --fit."
GRID = 10_000  # microseconds of a cycle in which values change


def write_fit(path: Path, specs: Specs, shown: Mapping[str, Shown]) -> list[Path]:
    """Write a bench file with the settings of its nodes, and what describes their devices.

    Returns:
        The files, the bench file first.

    Raises:
        UserError: one of them cannot be written, or the name does not end in .yaml.
    """
    if path.suffix.lower() not in devices.YAML or path.name.lower().endswith(".device.yaml"):
        raise UserError(f"{path}: the name of a bench file ends in .yaml, not in .device.yaml")
    nodes: dict[str, Any] = {}
    written = [path]
    for name, spec in specs.items():
        files = dict(_described(path, name, spec, shown[name]))
        for file, text in files.items():
            _write(file, text)
        written += files
        device = next((str(each.name) for each in files if each.suffix == ".yaml"), None)
        settings = {key: value for key, value in spec.settings.items() if key != "node_id"}
        nodes[Path(name).name] = {
            "device": device or _named(path, name, spec),
            "node_id": spec.create().node_id,
            **({"settings": settings} if settings else {}),
        }
    content = {"version": 1, "note": NOTE, "timing": "ideal", "nodes": nodes}
    _write(path, yaml.safe_dump(content, sort_keys=False, allow_unicode=True))
    return written


def _write(path: Path, text: str) -> None:
    try:
        write_whole(path, text)
    except OSError as failure:
        raise UserError(f"{path} cannot be written: {failure.strerror}") from failure


def _named(path: Path, name: str, spec: NodeSpec) -> str:
    """A device by its name, or by its file from where the bench file lies."""
    if not spec.device.files:
        return next(each for each in devices.names() if devices.find(each) is spec.device)
    return relpath(str(spec.device.files[0]), str(path.parent))


def _described(path: Path, name: str, spec: NodeSpec, shown: Shown) -> Iterator[tuple[Path, str]]:
    """The files of a device that an EDS describes: its values are those of the device."""
    files = spec.device.files
    if not files or files[0].suffix.lower() in devices.YAML:
        return
    stem = f"{path.stem}_{Path(name).stem}"
    moving = {address: each for address, each in shown.series.items() if len(each) > 1}
    fixed = {a: raw for a, raw in shown.raw.items() if a not in moving}
    dictionary = path.with_name(f"{stem}.dcf")
    yield dictionary, dcf(_with_values(spec, fixed))
    values: dict[str, Any] = {}
    for address, samples in moving.items():
        if address[0] < APPLICATION:
            continue
        file = path.with_name(f"{stem}_{address[0]:04X}_{address[1]:02X}.csv")
        text = io.StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(("seconds", "value"))
        for sample in samples:
            middle = (sample.before + sample.tick) / 2 - shown.begun
            rows.writerow((f"{max(middle, 0) / MICROSECONDS:.6f}", sample.value))
        yield file, text.getvalue()
        values[address_text(address)] = {"replays": file.name}
    content: dict[str, Any] = {"version": 1, "eds": dictionary.name, "note": NOTE}
    if values:
        content["values"] = values
    yield path.with_name(f"{stem}.device.yaml"), yaml.safe_dump(content, sort_keys=False)


def _with_values(spec: NodeSpec, values: Mapping[Address, bytes]) -> Device:
    """The same device, whose dictionary has other values from the beginning."""

    def dictionary(self: Device) -> ObjectDictionary:
        od = spec.device.dictionary(self)
        for (index, subindex), value in values.items():
            variable: Any = entries_of(od.indices[index])[subindex]
            variable.value = variable.decode_raw(value)
        return od

    kind: type[Device] = type("Fitted", (spec.device,), {"dictionary": dictionary})
    return kind(**{key: value for key, value in spec.settings.items() if key == "node_id"})
