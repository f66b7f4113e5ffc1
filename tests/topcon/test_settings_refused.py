import pytest

from canopen_twins import Bench, UserError


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"lod": "open"}, "unknown setting 'lod': did you mean 'load'?"),
        ({"load": "resitor 4"}, "setting 'load': no load is called 'resitor'"),
        ({"load": "resistor"}, "write 'resistor <ohm>'"),
        ({"load": "battery 350 -1"}, "ohm must be above 0"),
        ({"unit": "TCP-32-40"}, "unknown unit type 'TCP-32-40': did you mean 'TCP-32-400'?"),
        ({"unit_file": "nowhere.yaml"}, "nowhere.yaml: "),
        ({"units": 0}, "setting 'units' is 1 or more, not 0"),
        ({"units": 400, "connection": "series"}, "nominal_voltage must be a whole number of V"),
        ({"connection": "cascade"}, "is one of parallel, series, not 'cascade'"),
        ({"br": "six"}, "setting 'br' wants a whole number, not 'six'"),
        ({"serial": -1}, "setting 'serial' is 0 to 4294967295, not -1"),
        ({"serial": 1 << 32}, "setting 'serial' is 0 to 4294967295, not 4294967296"),
        ({"hardware_version": "V4.ü"}, "setting 'hardware_version' is ASCII text"),
        ({"firmware": "Ω"}, "setting 'firmware' is ASCII text"),
        ({"ready_time": -1}, "setting 'ready_time' is 0 or more, not -1"),
        ({"noise": -1}, "setting 'noise' is 0 or more, not -1"),
        ({"quiet_time": -1}, "setting 'quiet_time' is 0 or more, not -1"),
        ({"ambient": -300}, "setting 'ambient' is -273 or more, not -300"),
        ({"power_on_voltage": 4001}, "'power_on_voltage' is above 'set_value_range'"),
        ({"power_on_current": -1}, "setting 'power_on_current' is 0 to 32767, not -1"),
        ({"power_on_overvoltage": 4401}, "is 0 to 4400, not 4401"),
        ({"power_on_overcurrent": 4401}, "is 0 to 4400, not 4401"),
        ({"set_value_range": 32768}, "setting 'set_value_range' is 0 to 32767, not 32768"),
        ({"strict_cobid": "perhaps"}, "wants true or false, not 'perhaps'"),
        ({"empty_1003": "none"}, "is one of zero, abort, not 'none'"),
        ({"hb_first": "soon"}, "is one of period, now, not 'soon'"),
        ({"local_write": "drop"}, "is one of ignore, abort, not 'drop'"),
        ({"on_remote": "go"}, "is one of keep, stop, not 'go'"),
        ({"on_leave_operational": "go"}, "is one of keep, stop, not 'go'"),
        ({"run_while_error": "go"}, "is one of ignore, abort, emcy, not 'go'"),
        ({"ovp_when_off": "go"}, "wants true or false, not 'go'"),
        ({"panel": "off"}, "is one of remote, local, not 'off'"),
    ],
    ids=str,
)
def test_a_wrong_setting_is_refused_in_one_line(settings, message):
    with pytest.raises(UserError) as refusal:
        Bench("topcon", **settings)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("name", ["firmware", "serial", "unit", "ready_time", "run_while_error"])
def test_what_belongs_to_the_unit_cannot_change_while_it_runs(topcon, name):
    with pytest.raises(UserError, match=f"setting '{name}' is taken over at power-on only"):
        topcon.set(**{name: getattr(topcon.device.settings, name)})
