import pytest

from canopen_twins.devices.gateway.model.bootloader import (
    FROM_BOOTLOADER,
    Eeprom,
    EndlessLoop,
    Finding,
)
from canopen_twins.devices.gateway.model.canopen_side import BootUp
from canopen_twins.devices.gateway.model.state import GatewayState

UNITS = ["gateway", "governor"]


def boot(rig, seconds=3.0):
    rig.system.power_on()
    return [message for _, message in rig.run(seconds)]


@pytest.mark.spec("G-210")
@pytest.mark.parametrize("test", EndlessLoop)
def test_an_endless_loop_is_silent_for_ever(plain, test):
    rig = plain()
    rig.gateway.bootloader.finding = test
    assert boot(rig) == []
    with pytest.raises(ValueError, match="no answer, the unit is kept in the bootloader"):
        rig.gateway.desk.read(3800)


@pytest.mark.spec("G-211")
def test_a_failed_ram_test_is_told_by_the_bootloader(plain):
    rig = plain()
    rig.gateway.bootloader.finding = Finding.of_test(1, (0x1234, 0x5555, 0x5515))
    assert boot(rig) == []
    desk = rig.gateway.desk
    assert [desk.read(number) for number in (3078, *range(3800, 3804))] == [
        1,
        1,
        0x1234,
        0x5555,
        0x5515,
    ]


@pytest.mark.spec("G-212", "G-214")
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("status", range(1, 11))
def test_every_test_status_has_its_error(plain, unit, status):
    rig = plain()
    faulty = getattr(rig, unit)
    faulty.bootloader.finding = Finding.of_test(status, (1, 2, 3))
    assert boot(rig) == []
    expected = {1: 3078, 10: 3076}.get(status, 3087)
    errors = [number for number in (3076, 3078, 3087, 3089) if faulty.desk.read(number)]
    assert (errors, faulty.desk.read(3800)) == ([expected], status)
    assert [faulty.desk.read(number) for number in (3801, 3802, 3803)] == [1, 2, 3]


def test_there_is_no_eleventh_test_status(plain):
    with pytest.raises(ValueError, match=r"3800 TestStatus: 11 is not in 1..10"):
        plain().gateway.bootloader.finding = Finding.of_test(11)


@pytest.mark.spec("G-213")
def test_a_watchdog_that_fired_is_told_with_its_place(plain):
    rig = plain()
    rig.gateway.bootloader.finding = Finding.of_watchdog(address=0x00ABCDEF, flags=0x0003)
    assert boot(rig) == []
    desk = rig.gateway.desk
    assert desk.read(3089) == 1
    assert [desk.read(number) for number in range(3095, 3099)] == [3, 0xCDEF, 0x00AB, 3]


@pytest.mark.parametrize("unit", UNITS)
def test_the_bootloader_answers_for_its_own_parameters_only(plain, unit):
    rig = plain()
    getattr(rig, unit).bootloader.finding = Finding.of_test(9)
    boot(rig)
    desk = getattr(rig, unit).desk
    for number in FROM_BOOTLOADER:
        desk.read(number)
    with pytest.raises(ValueError, match="no answer"):
        desk.read(401)
    with pytest.raises(ValueError, match="no answer"):
        desk.write(401, 2)


def test_while_it_starts_a_unit_does_not_answer(plain):
    rig = plain()
    for life in ("switched off", "in the start tests"):
        with pytest.raises(ValueError, match=f"no answer, the unit is {life}"):
            rig.gateway.desk.read(427)
        rig.system.power_on()


@pytest.mark.parametrize("unit", UNITS)
def test_a_unit_works_again_when_the_finding_is_gone(plain, unit):
    rig = plain()
    getattr(rig, unit).bootloader.finding = Finding.of_test(9)
    boot(rig)
    getattr(rig, unit).bootloader.finding = None
    getattr(rig, unit).reset()
    assert BootUp() in [message for _, message in rig.run(1.0)]


@pytest.mark.spec("G-020")
@pytest.mark.parametrize("boot_time", [0.1, 0.3])
def test_the_start_takes_its_time(plain, boot_time):
    rig = plain(boot_time=boot_time)
    rig.system.power_on()
    ((at, _),) = rig.run(0.5)
    assert boot_time * 1000 + 20 < at < boot_time * 1000 + 25


@pytest.mark.spec("G-192")
def test_eeprom_errors_take_effect_at_the_next_start(plain):
    rig = plain({"gateway": {427: 9}}).on()
    unit = rig.gateway
    unit.break_off(1)
    rig.run(0.05)
    unit.mend(3094)
    unit.bootloader.eeprom_code = sum(
        1 << part.value for part in Eeprom if part is not Eeprom.BOOTLOADER_PAGE
    )
    unit.reset()
    rig.run(0.5)
    assert rig.system.state is GatewayState.PRE_OPERATIONAL
    assert unit.desk.read(3099) == 0b111_1000
    assert [unit.desk.read(number) for number in (3194, 3195, 3844, 3845)] == [0, 0, 0, 0]
    assert rig.system.dictionary.tpdos[1].identifier == 0x181


@pytest.mark.spec("G-192")
def test_a_faulty_bootloader_page_keeps_the_programme_in_the_bootloader(plain):
    rig = plain()
    rig.gateway.bootloader.eeprom_code = 1
    assert boot(rig) == []
    assert rig.gateway.desk.read(3840) == 100
