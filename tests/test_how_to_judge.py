import pytest
import yaml
from test_how_to import DOCS, INSTALLING, carried_out, checkout_of, files, port  # noqa: F401

PAGE = DOCS / "how-to" / "let-a-file-judge-your-master.md"


@pytest.fixture
def checkout(tmp_path):
    """A project with a master and its stories, as the page shows it."""
    return checkout_of(PAGE, tmp_path)


def test_the_jobs_of_both_services_do_what_they_say(checkout, port):  # noqa: F811
    shown = files(PAGE)
    steps = yaml.safe_load(shown[".github/workflows/stories.yml"])["jobs"]["stories"]["steps"]
    lines = [step["run"] for step in steps if "run" in step]
    job = yaml.safe_load(shown[".gitlab-ci.yml"])["stories"]
    assert [*job["before_script"], *job["script"]] == lines
    script = "\n".join(line for line in lines if not INSTALLING.match(line))
    done = carried_out(script.replace("auto", "2"), checkout, port)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout
    assert (checkout / "report.xml").read_text().count('name="canopen_verdict" value="PASS"') == 2


def test_a_master_in_any_language_is_judged(checkout, port):  # noqa: F811
    script = (checkout / "ci" / "judge.sh").read_text()
    done = carried_out(script, checkout, port)
    assert done.returncode == 0, done.stdout + done.stderr
    assert 'failures="0" errors="0"' in (checkout / "report.xml").read_text()


def test_a_master_that_goes_on_is_found_guilty(pytester):
    master = checkout_of(PAGE, pytester.path) / "battery.py"
    master.write_text(master.read_text().replace(" and not errors", ""))
    run = pytester.runpytest_inprocess("-q", "-p", "no:cacheprovider", "test_battery.py")
    said = run.stdout.str()
    assert run.ret == 1
    assert "stories/trip.yaml: FAIL (3 PASS, 1 FAIL)" in said
    assert "trip.yaml:14: topcon: write Run command = 0 within 0.5 s: none came" in said
