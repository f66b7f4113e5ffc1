"""What people type: the examples at the end of every --help and in the man page."""

from collections.abc import Mapping, Sequence

EXAMPLES: Mapping[str, Sequence[str]] = {
    "list": ("list", "list topcon", "list --json"),
    "eds": ("eds topcon", "eds topcon -n 5 --set unit=TCP-32-400-IBC"),
    "objects": ("objects charger", "objects drive.eds --json"),
    "settings": ("settings gateway", "settings topcon --json"),
    "why": ("why topcon 0x2014", "why topcon 'Run command=7'", "why charger 0x2002:08=40000"),
    "faults": ("faults", "faults topcon", "faults drive.eds --json"),
    "inject": ("inject interlock_open", "inject heartbeat_late seconds=0.5 --node topcon"),
    "clear": ("clear", "clear interlock_open"),
    "set": ("set 'load=resistor 4'", "set Temperature=900 --at 127.0.0.1:8123"),
    "get": ("get 'Actual voltage'", "get 0x1018:01 --json"),
    "power": ("power off", "power on 'load=resistor 4'"),
    "state": ("state", "state --json"),
    "watch": ("watch", "watch --kind emcy --kind state"),
    "run": (
        "run topcon -n 5 --hub",
        "run topcon -n 5 -i socketcan -c vcan0 --set load='resistor 4 ohm'",
        "run bench.yaml --hub --control",
        "run --scenario topcon_overvoltage.yaml --hub --junit report.xml -- python master.py",
    ),
    "hub": ("hub", "hub --listen 127.0.0.1:0"),
    "play": (
        "play topcon_overvoltage.yaml",
        "play stories/trip.twin.yaml --junit report.xml",
        "play trip.yaml --plot trip.html --record kept",
        "play hunt-1.twin.yaml --master my_master:main",
    ),
    "hunt": (
        "hunt contract.yaml --master my_master:main",
        "hunt contract.yaml --master my_master:main --seconds 600 --jobs 2 --finds finds",
        "hunt contract.yaml --seconds 1800 -- ./master {interface} {channel}",
    ),
    "conform": ("conform topcon", "conform drive.eds -n 5 -i socketcan -c vcan0"),
    "campaign": (
        "campaign nightly.yaml --master my_master:main --jobs 2",
        "campaign nightly.yaml --dask tcp://127.0.0.1:8786 --upload my_master.py --json runs.json",
    ),
    "check": ("check trip.yaml bench.yaml drive.eds",),
    "schema": ("schema", "schema bench"),
    "new-device": ("new-device pump",),
    "replay": ("replay kept",),
    "diff": ("diff before after", "diff before.log after.log"),
    "decode": ("decode field.log --eds 5=topcon",),
    "compare": ("compare topcon -n 5 field.log",),
    "vcan": ("vcan -- candump vcan0", "vcan --out kept -- sh -eu ci/master.sh"),
    "completion": (
        "completion bash > ~/.local/share/bash-completion/completions/canopen-twin",
        "completion zsh > ~/.zfunc/_canopen-twin",
        "completion fish > ~/.config/fish/completions/canopen-twin.fish",
    ),
    "man": ("man > canopen-twin.1",),
}
"""By command, without the name of the program."""
