"""The stand-in of the service is one that Ocean's own samplers talk to."""

import dimod
import pytest
from service import Service

QUBO = {(0, 0): -1, (0, 1): 2, (1, 1): -1, (1, 2): 1, (0, 2): 1}


@pytest.fixture(params=[True, False], ids=["at once", "polled"])
def service(request, monkeypatch):
    with Service(immediate=request.param) as service:
        service.pending = service.delay = 0 if request.param else 1
        for name, value in service.environment.items():
            monkeypatch.setenv(name, value)
        yield service


def test_quantum_annealer(service):
    from dwave.system import DWaveSampler, EmbeddingComposite
    with EmbeddingComposite(DWaveSampler()) as sampler:
        found = sampler.sample_qubo(QUBO, num_reads=100, label="three")
        assert (found.first.energy == -1 and found.info["timing"]["qpu_access_time"] > 0
                and found.info["problem_label"] == "three")
        found = sampler.sample_ising({"a": 1}, {"ab": -1}, num_reads=10)
        assert found.first.energy == -2
    assert len(service.problems) == 2


def test_hybrid_solvers(service):
    from dwave.optimization import Model
    from dwave.system import LeapHybridCQMSampler, LeapHybridNLSampler, LeapHybridSampler
    bqm = dimod.BinaryQuadraticModel.from_qubo(QUBO)
    with LeapHybridSampler() as sampler:
        found = sampler.sample(bqm)
        assert found.first.energy == -1 and found.info["charge_time"] > 0
    cqm = dimod.ConstrainedQuadraticModel()
    cqm.set_objective(bqm)
    cqm.add_discrete([0, 1, 2], label="one")
    with LeapHybridCQMSampler() as sampler:
        found = sampler.sample_cqm(cqm)
        assert found.first.is_feasible and found.first.energy == -1
    model = Model()
    x = model.integer(4, lower_bound=0, upper_bound=3)
    model.minimize(((x - 2)**2).sum())
    with LeapHybridNLSampler() as sampler:
        sampler.sample(model).result()
        with model.lock():
            assert x.state(0).tolist() == [2, 2, 2, 2] and model.objective.state(0) == 0
    assert len(service.problems) == 3
