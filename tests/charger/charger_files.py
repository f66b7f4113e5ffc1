"""The EDS files of the charger as canopen reads them for node 99."""

import canopen
from canopen.objectdictionary import ODVariable

from canopen_twins.devices.charger.model.types import PCSC, Build, Variant
from canopen_twins.devices.charger.object_table import file_name
from canopen_twins.files.shipped import od_file

NODE_ID = 99


def load(kind=PCSC, variant=Variant.A):
    with od_file(file_name(Build(kind, variant))) as path:
        return canopen.import_od(str(path), NODE_ID)


def entries(od):
    found = {}
    for item in od.values():
        subs = {0: item} if isinstance(item, ODVariable) else item.subindices
        found |= {(item.index, sub): variable for sub, variable in subs.items()}
    return found


def values(od, index):
    return [variable.default for variable in od[index].subindices.values()]
