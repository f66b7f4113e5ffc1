"""What tests of hunts share."""

import pytest

from canopen_twins.cli import main

from .masters import CONTRACT


@pytest.fixture
def hunted(tmp_path, monkeypatch, capsys):
    """Hunt a master; exit code and what is said."""
    monkeypatch.chdir(tmp_path)

    def hunted(master, *arguments, contract=CONTRACT):
        (tmp_path / "my_master.py").write_text(master)
        (tmp_path / "contract.yaml").write_text(contract)
        named = ["--master", "my_master:main", *arguments]
        code = main(["hunt", "contract.yaml", *named])
        said = capsys.readouterr()
        return code, said.out + said.err

    return hunted
