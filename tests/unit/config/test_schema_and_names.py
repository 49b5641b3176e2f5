"""The JSON Schema for editors, and finding files by name."""

import json

import pytest

from rig.config import experiment_schema, find_configs, find_file, list_files, profile_schema
from rig.hal import ConfigurationError


def references(schema):
    if isinstance(schema, dict):
        for key, item in schema.items():
            if key == "$ref":
                yield item
            else:
                yield from references(item)
    elif isinstance(schema, list):
        for item in schema:
            yield from references(item)


class TestSchema:
    def test_every_alternative_is_in_it(self, configs):
        schema = profile_schema(configs.registry)
        definitions = schema["$defs"]
        valve = definitions["driver_valve_module"]
        assert valve["properties"]["driver"] == {
            "const": "valve-module", "title": "Driver", "type": "string"
        }  # fmt: skip
        assert set(valve["properties"]) == {
            "driver", "bus", "serial", "calibration", "node", "channels", "watchdog", "scaling"
        }  # fmt: skip
        assert valve["required"] == ["driver", "node", "channels"]
        assert valve["additionalProperties"] is False
        assert valve["properties"]["node"]["description"] == "Its number on the bus."
        assert set(definitions["Controllers"]["properties"]) == {"pid", "cascade"}
        assert {"cylinder", "joint", "plant", "extends"} <= set(
            definitions["Profile"]["properties"]
        )

    def test_a_number_with_a_unit_may_be_text(self, configs):
        definitions = profile_schema(configs.registry)["$defs"]
        number, text = definitions["ChannelSettings"]["properties"]["full_scale"]["anyOf"]
        assert number == {"minimum": 1e-3, "maximum": 1e7, "type": "number"}
        assert text["type"] == "string"
        assert "kPa" in text["description"]
        assert definitions["ChannelSettings"]["properties"]["number"]["type"] == "integer"

    @pytest.mark.parametrize("make", [profile_schema, experiment_schema])
    def test_whole_and_nothing_required_of_a_file_that_extends(self, configs, make):
        schema = make(configs.registry)
        json.dumps(schema)
        for reference in references(schema):
            assert reference.removeprefix("#/$defs/") in schema["$defs"]
        partial = schema["$defs"][schema["then"]["$ref"].removeprefix("#/$defs/")]
        assert "required" not in partial
        assert all(ref.endswith("Partial") for ref in references(partial))
        full = schema["$defs"][schema["else"]["$ref"].removeprefix("#/$defs/")]
        assert "required" in full


class TestNames:
    def test_an_earlier_folder_hides_a_later_one(self, tmp_path):
        for folder, names in (("a", ["x", "y"]), ("b", ["y", "z"])):
            (tmp_path / folder / "rigs").mkdir(parents=True)
            for name in names:
                (tmp_path / folder / "rigs" / f"{name}.yaml").touch()
        (tmp_path / "a/rigs/notes.txt").touch()
        search = [tmp_path / "a", tmp_path / "b", tmp_path / "none"]
        assert list_files("rigs", search) == {
            "x": tmp_path / "a/rigs/x.yaml",
            "y": tmp_path / "a/rigs/y.yaml",
            "z": tmp_path / "b/rigs/z.yaml",
        }
        assert find_file("z", "rigs", search) == tmp_path / "b/rigs/z.yaml"
        assert list_files("experiments", search) == {}

    def test_nearest_name_and_where_it_looked(self, configs):
        with pytest.raises(ConfigurationError, match="did you mean bench-sine"):
            find_file("bench-sin", "experiments", [configs.path])
        with pytest.raises(ConfigurationError, match="looked in nowhere"):
            find_file("x", "rigs", [])

    def test_the_working_directory_comes_first(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "configs").mkdir()
        assert find_configs()[0].resolve() == tmp_path / "configs"
        assert find_configs(tmp_path) == (tmp_path,)
        with pytest.raises(ConfigurationError, match="not a folder"):
            find_configs(tmp_path / "none")
