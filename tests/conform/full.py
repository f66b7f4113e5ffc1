"""A file that declares every service, so that its twin has to do with every topic."""

from services.declared import BASE, TEXT, U8, U16, U32, entry, record

HISTORY = record("1003", (U32, 0, "ro"), (U32, 0, "ro")).replace(
    "DefaultValue=2\n", "DefaultValue=0\n"
)
SECTIONS = (
    HISTORY.replace("AccessType=const", "AccessType=rw"),
    entry("1005", U32, "0x80"),
    entry("1006", U32, 0),
    entry("1008", TEXT, "A drive of many words", "const"),
    entry("100C", U16, 0),
    entry("100D", U8, 0),
    record("1010", (U32, 0)),
    record("1011", (U32, 0)),
    entry("1014", U32, "$NODEID+0x80"),
    record("1016", (U32, 0), (U32, 0)),
    record("1018", *((U32, value, "ro") for value in (0x123, 1, 1, 77))),
    entry("1019", U8, 0),
    record("1029", (U8, 0)),
    record("1200", (U32, "$NODEID+0x600", "ro"), (U32, "$NODEID+0x580", "ro")),
    record("1800", (U32, "$NODEID+0x180"), (U8, 1), (U16, 0), (U8, 0), (U16, 0)),
    entry("2002", U8, "", "wo"),
    entry("2003", U16, 50, more="LowLimit=10\nHighLimit=100\n"),
)


def write_full(folder):
    """The path of the file, beside which there is nothing."""
    text = BASE.replace("LSS_Supported=0", "LSS_Supported=1")
    for index, following in (("1018", "1400"), ("1800", "1A00")):
        text = text[: text.index(f"[{index}]")] + text[text.index(f"[{following}]") :]
    path = folder / "full.eds"
    path.write_text(text + "".join(SECTIONS), "ascii")
    return path
