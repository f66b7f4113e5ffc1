def test_it_follows_its_target_speed(fan):
    fan.sdo["Target speed"].raw = 1500
    fan.run(0.5)
    assert 0 < fan.sdo["Actual speed"].raw < 1500
    fan.run(5.0)
    assert fan.sdo["Actual speed"].raw == 1500


def test_a_speed_above_the_limit_is_refused(fan):
    assert fan.send("601#2B002000B80B0000") == ["581#6000200000000000"]  # 3000 rpm
    assert fan.send("601#2B002000B90B0000") == ["581#8000200031000906"]  # 3001: value too high


def test_a_blocked_wheel_is_told(canopen_bench):
    fan = canopen_bench("fan", node_id=9, time_constant=0.1)
    fan.inject("blocked")
    assert fan.sent[-1] == "089#2171810000000000"
    fan.clear("blocked")
    assert fan.sent[-1] == "089#0000000000000000"


def test_its_speed_goes_out_with_every_sync(fan):
    fan.sdo["Target speed"].raw = 1500
    fan.run(10.0)
    fan.send("000#0101")
    assert fan.send("080#") == ["181#DC05"]
