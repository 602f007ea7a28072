"""FMUs in tests: one instance by FMPy, whatever the version of FMI."""

from __future__ import annotations

import pytest

fmpy = pytest.importorskip("fmpy", reason="FMPy runs the units")


class Unit:
    """An instance of an FMU, driven by names; `said` has what it logged."""

    def __init__(self, file, folder):
        self.about = fmpy.read_model_description(str(file))
        self.version = self.about.fmiVersion[0]
        self.said = []
        self.variables = {v.name: v for v in self.about.modelVariables}
        fmpy.extract(str(file), str(folder))
        self.fmu = fmpy.instantiate_fmu(str(folder), self.about, "CoSimulation", logger=self._hear)

    def _hear(self, *words):
        text = words[-1] if self.version == "3" else words[4]
        self.said.append(text.decode() if isinstance(text, bytes) else text)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.fmu.freeInstance()

    def begin(self, start_time=0.0, tolerance=None, **values):
        self.set(**values)
        if self.version == "2":
            self.fmu.setupExperiment(tolerance=tolerance, startTime=start_time)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=start_time)
        self.fmu.exitInitializationMode()

    def set(self, **values):
        for name, value in values.items():
            call = self.fmu.setReal if self.version == "2" else self.fmu.setFloat64
            call([self.variables[name].valueReference], [value])

    def get(self, name):
        v = self.variables[name]
        real = v.type in ("Real", "Float64")
        if self.version == "2":
            call = self.fmu.getReal if real else self.fmu.getInteger
        else:
            call = self.fmu.getFloat64 if real else self.fmu.getInt64
        return call([v.valueReference])[0]

    def step(self, time, size):
        return self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def state(self, action, *arguments):
        """Get, set, free, serialize or deserialize a state of the FMU."""
        verb = "deSerialize" if (self.version, action) == ("2", "deserialize") else action
        noun = "FMUstate" if self.version == "2" else "FMUState"
        return getattr(self.fmu, verb + noun)(*arguments)

    def mode(self, name="mode"):
        """Return the name of a mode."""
        known = self.variables[name].declaredType.items
        return {int(item.value): item.name for item in known}[int(self.get(name))]
