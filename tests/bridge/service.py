"""A stand-in for D-Wave's service on the loopback interface, for D-Wave's own clients to talk to
over HTTP.

It speaks the parts of the Solver API that a problem's life needs: solver lists, multipart upload,
submission, polling, answers, cancellation, and the list of problems. Real samplers solve behind it.
It counts the problems that it was made to create, keeps what it was sent, and misbehaves when told
to:

    with Service() as service:
        service.fail("POST", "problems/", 500)          # the next such request is answered so
        environment.update(service.environment)
"""

import base64
import functools
import hashlib
import io
import json
import re
import threading
import uuid
import zlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, urlsplit

import numpy as np

TOKEN = "DEV-" + "0123456789abcdef" * 2 + "01234567"
PREFIX = "/sapi/v2/"
MEDIA = "application/vnd.dwave.sapi.{}+json; version=3.0.0"

QPU_TIMING = {"qpu_sampling_time": 80000.0, "qpu_anneal_time_per_sample": 20.0,
              "qpu_readout_time_per_sample": 39.4, "qpu_access_time": 94072.0,
              "qpu_access_overhead_time": 1290.0, "qpu_programming_time": 14072.0,
              "qpu_delay_time_per_sample": 20.54, "total_post_processing_time": 457.0,
              "post_processing_overhead_time": 457.0}
HYBRID_TIMING = {"qpu_access_time": 41000, "charge_time": 5000000, "run_time": 5123456}


@functools.cache
def described(tiles=3):
    """JSON: one solver of each kind, by name, as D-Wave's own tests describe them; the chip is a
    Zephyr of so many tiles each way. To build its graph takes longer than most tests."""
    from dwave.cloud.testing import mocks
    parameters = dict.fromkeys(["num_reads", "annealing_time", "anneal_schedule", "initial_state",
                                "reinitialize_state", "fast_anneal", "answer_mode", "auto_scale"],
                               "")
    limits = {"maximum_number_of_variables": 1_000_000, "maximum_number_of_biases": 200_000_000}
    solvers = [mocks.qpu_zephyr_solver_data(tiles, name="Advantage2_mock", parameters=parameters,
                                            h_range=[-4.0, 4.0], num_reads_range=[1, 10000],
                                            annealing_time_range=[0.5, 2000.0],
                                            default_annealing_time=20.0,
                                            max_anneal_schedule_points=12,
                                            fast_anneal_time_range=[0.005, 83000.0],
                                            problem_timing_data=mocks.qpu_problem_timing_data(),
                                            chip_id="Advantage2_mock"),
               mocks.hybrid_bqm_solver_data(minimum_time_limit=[[1, 3.0], [1024, 3.0], [4096, 10.0],
        [10000, 40.0], [30000, 200.0], [100000, 600.0], [1000000, 600.0]], **limits),
               mocks.hybrid_cqm_solver_data(minimum_time_limit_s=5,
                                            maximum_number_of_constraints=100_000,
                                            num_variables_multiplier=1.574e-4,
                                            num_biases_multiplier=4.657e-6,
                                            num_constraints_multiplier=6.444e-9,
                                            **{**limits, "maximum_number_of_variables": 5_000_000,
                                               "maximum_number_of_biases": 750_000_000}),
               mocks.hybrid_nl_solver_data(maximum_decision_state_size=50 << 20,
                                           maximum_number_of_nodes=2_000_000,
                                           maximum_state_size=750 << 20)]
    return json.dumps({data["identity"]["name"]: data for data in solvers}, default=int)


class Solving:
    """Samplers behind the service: problem data and parameters in, the field `answer` out."""

    @staticmethod
    def ising(service, properties, data, params, vartype="SPIN"):
        import dimod
        qubits, couplers = properties["qubits"], properties["couplers"]
        h = np.frombuffer(base64.b64decode(data["lin"]), "<f8")
        used = {qubit for qubit, bias in zip(qubits, h) if not np.isnan(bias)}
        active = [(p, q) for p, q in couplers if p in used and q in used]
        J = np.frombuffer(base64.b64decode(data["quad"]), "<f8")
        assert J.size == len(active)
        bqm = dimod.BinaryQuadraticModel({qubit: bias for qubit, bias in zip(qubits, h)
                                          if qubit in used},
                                         {pair: bias for pair, bias in zip(active, J) if bias}, 0.0,
                                         vartype)
        sampleset = service.sample(bqm, params.get("num_reads", 1))
        order = np.argsort(sampleset.variables)
        record = sampleset.record
        encode = lambda array, dtype: base64.b64encode(np.ascontiguousarray(array,
            dtype).tobytes()).decode()
        return {"format": "qp", "active_variables": encode(np.array(sampleset.variables)[order],
                                                           "<i4"), "energies": encode(record.energy,
            "<f8"), "num_occurrences": encode(record.num_occurrences, "<i4"),
                "solutions": encode(np.packbits(record.sample[:, order] > 0, axis=1), "u1"),
                "num_variables": properties["num_qubits"], "timing": QPU_TIMING}

    @staticmethod
    def qubo(service, properties, data, params):
        return Solving.ising(service, properties, data, params, "BINARY")

    @staticmethod
    def bqm(service, properties, data, params):
        import dimod
        sampleset = service.sample(dimod.BinaryQuadraticModel.from_file(io.BytesIO(data)), 20)
        return {"format": "bq", "data": sampleset.truncate(10, sorted_by="energy").to_serializable()
                | {"info": HYBRID_TIMING}}

    @staticmethod
    def cqm(service, properties, data, params):
        import dimod
        cqm = dimod.ConstrainedQuadraticModel.from_file(io.BytesIO(data))
        bqm, invert = dimod.cqm_to_bqm(cqm, lagrange_multiplier=1000)
        found = [invert(sample) for sample in service.sample(bqm,
                                                             20).samples(sorted_by="energy")[:10]]
        samples = dimod.SampleSet.from_samples_cqm(found, cqm)
        # Hybrid solvers answer in floating point.
        samples = dimod.SampleSet.from_samples((samples.record.sample.astype(float),
                                                samples.variables), energy=samples.record.energy,
                                               vartype="BINARY",
                                               is_feasible=samples.record.is_feasible)
        return {"format": "bq", "data": samples.to_serializable() | {"info": HYBRID_TIMING}}

    @staticmethod
    def nl(service, properties, data, params):
        """Each decision's elements in turn take their best value, until none changes; from a few
        random states."""
        from dwave.optimization import Model
        model, rng = Model.from_file(io.BytesIO(data)), np.random.default_rng(1)
        decision = next(model.iter_decisions())
        high = (np.broadcast_to(decision.upper_bound(), decision.size()).astype(int)
                if hasattr(decision, "upper_bound") else np.ones(decision.size(), int))
        with model.lock():
            model.states.resize(2)

            def energy(state):
                decision.set_state(0, state)
                return model.objective.state(0)
            best = None
            for _ in range(10):
                state = rng.integers(0, high + 1, decision.size())
                before, now = np.inf, energy(state)
                while now < before:
                    before = now
                    for at in range(state.size):
                        tried = [energy(np.where(np.arange(state.size) == at, value, state))
                                 for value in range(high[at] + 1)]
                        state[at] = int(np.argmin(tried))
                        now = min(tried)
                if best is None or now < best[0]:
                    best = now, state
            decision.set_state(0, best[1])
            decision.set_state(1, rng.integers(0, high + 1, decision.size()))
            with model.states.to_file() as file:
                service.answers[params["id"]] = file.read()
        return {"format": "binary-ref", "auth_method": "sapi-token",
                "url": f"{service.url}answers/{params['id']}",
                "timing": HYBRID_TIMING | {"warnings": []}, "shape": {}}


class Problem:
    """One problem at the service. It is PENDING for as many questions as the service says, then
    IN_PROGRESS for as many, then has its outcome: no clock is looked at."""

    def __init__(self, service, job):
        self.id, self.job, self.service = str(uuid.uuid4()), job, service
        self.label, self.questions, self.cancelled, self.answer = job.get("label"), 0, False, None

    @property
    def status(self):
        service = self.service
        if self.cancelled:
            return "CANCELLED"
        if self.questions <= service.pending and service.pending:
            return "PENDING"
        running = service.delay and self.questions <= service.pending + service.delay
        return "IN_PROGRESS" if running else service.outcome

    def asked(self):
        """The problem, after one more question for it."""
        self.questions += 1
        return self

    def message(self, answer=False):
        status, stamp = self.status, "2026-01-02T03:04:05.000006Z"
        found = {"id": self.id, "type": self.job["type"], "solver": self.job["solver"],
                 "label": self.label, "status": status, "submitted_on": stamp}
        if status == "FAILED":
            found["error_message"] = self.service.reason
        if status == "COMPLETED":
            found["solved_on"] = stamp
            if answer:
                found["answer"] = self.solve()
        return found

    def solve(self):
        with self.service.lock:
            if self.answer is None:
                data, properties = (self.job["data"], self.service.solvers[
                    self.job["solver"]["name"]]["properties"])
                data = (data if data["format"] == "qp" else self.service.uploads[data["data"]][
                    "whole"])
                self.answer = getattr(Solving, self.job["type"])(self.service, properties, data,
                    {**self.job["params"], "id": self.id})
                if self.service.spoil:
                    self.answer = self.service.spoil(self.answer)
        return self.answer


class Service:
    """The service: set `pending`, `delay` (how many questions for a problem find it so), `outcome`,
    `reason`, `spoil` (a function of the answer), `sampler`, `patience` (seconds that replies 429
    and 503 ask for), `elsewhere` (where a 307 leads to); see fail(). `closed` is set at its end."""

    def __init__(self, solvers=None, immediate=True):
        self.solvers = json.loads(described()) if solvers is None else solvers
        self.problems, self.uploads, self.answers, self.requests, self.faults = {}, {}, {}, [], []
        self.pending, self.delay, self.outcome, self.reason = 0, 0, "COMPLETED", "it failed"
        self.spoil, self.closed = None, threading.Event()
        self.immediate, self.sampler, self.lock = immediate, None, threading.RLock()
        self.patience, self.elsewhere = None, None
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), type("Handler", (_Handler,),
            {"service": self}))
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}{PREFIX}"
        self.environment = {"DWAVE_API_ENDPOINT": self.url, "DWAVE_API_TOKEN": TOKEN,
                            "DWAVE_CONFIG_FILE": "/dev/null", "DWAVE_CACHE_ENABLED": "false",
                            "NO_PROXY": "127.0.0.1"}

    def __enter__(self):
        threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.02},
                         daemon=True).start()
        return self

    def __exit__(self, *error):
        self.closed.set()
        self.server.shutdown()
        self.server.server_close()

    def fail(self, method, path, how, times=1):
        """What happens to the next `times` requests whose method and path match the expressions.

        `how` is a status of HTTP; "drop" (the connection is closed, the request forgotten); "drop
        after" and "500 after" (it is carried out first); or a function that is called first and may
        give one of these. A tuple (headers, parts of a body) is sent as it is, with status 200."""
        self.faults.append([method, re.compile(path), how, times])

    def fault(self, method, path):
        for fault in self.faults:
            if re.fullmatch(fault[0], method) and fault[1].search(path) and fault[3] > 0:
                fault[3] -= 1
                return fault[2]
        return None

    def sample(self, bqm, reads):
        """Samples of a binary quadratic model: all states of a tiny one, else annealed and
        descended."""
        from dimod import ExactSolver
        from dwave.samplers import SimulatedAnnealingSampler, SteepestDescentSampler
        if self.sampler:
            return self.sampler.sample(bqm, num_reads=reads)
        if bqm.num_variables <= 18:
            return ExactSolver().sample(bqm).truncate(reads, sorted_by="energy")
        annealed = SimulatedAnnealingSampler().sample(bqm, num_reads=min(reads, 200),
                                                      num_sweeps=200, seed=1)
        return SteepestDescentSampler().sample(bqm, initial_states=annealed)


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    service = None

    def log_message(self, *arguments):
        pass

    def _body(self):
        if self.headers.get("Transfer-Encoding") == "chunked":
            parts = []
            while size := int(self.rfile.readline(), 16):
                parts.append(self.rfile.read(size))
                self.rfile.readline()
            self.rfile.readline()
            body = b"".join(parts)
        else:
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        return zlib.decompress(body) if self.headers.get("Content-Encoding") == "deflate" else body

    def _reply(self, status, content, media="problems"):
        data = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/octet-stream" if isinstance(content, bytes)
                         else MEDIA.format(media))
        self.send_header("Content-Length", str(len(data)))
        if status in (429, 503) and self.service.patience is not None:
            self.send_header("Retry-After", str(self.service.patience))
        if status == 307:
            self.send_header("Location", self.service.elsewhere + "problems/")
        if self.close_connection:
            # As servers do; the client would use the connection again otherwise.
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(data)

    def _raw(self, headers, parts):
        """A reply of any content: its headers, and its body in parts that are sent as they are."""
        self.close_connection = True
        self.send_response(200)
        for name, value in {**headers, "Connection": "close"}.items():
            self.send_header(name, value)
        self.end_headers()
        for part in parts:
            self.wfile.write(part)

    def _error(self, status, said):
        self._reply(status, {"error_code": status, "error_msg": said})

    def _serve(self):
        method, url = self.command, urlsplit(self.path)
        path, query = (url.path.removeprefix(PREFIX), {key: values[0] for key,
                                                       values in parse_qs(url.query).items()})
        how, body = self.service.fault(method, path), self._body()
        self.service.requests.append((method, self.path, body))
        if callable(how):
            how = how()
        if isinstance(how, tuple):
            return self._raw(*how)
        if how == "drop":
            self.close_connection = True
            return self.connection.close()
        if isinstance(how, int):
            return self._error(how, "as it was told")
        if self.headers.get("X-Auth-Token") != TOKEN:
            return self._error(401, "Invalid token or access denied")
        for pattern, action in self.ROUTES:
            if found := re.fullmatch(pattern, f"{method} {path}"):
                reply = action(self, query, body, *found.groups())
                break
        else:
            reply = 404, {"error_code": 404, "error_msg": "no such resource"}
        if how == "drop after":
            self.close_connection = True
            return self.connection.close()
        if how == "500 after":
            return self._error(500, "as it was told")
        return self._reply(*reply)

    do_GET = do_POST = do_PUT = do_DELETE = lambda self: self._quietly(self._serve)

    def _quietly(self, serve):
        try:
            serve()
        except (ConnectionError, ValueError) as error:
            # The client has gone; that is what some tests are about.
            self.close_connection = True
            if isinstance(error, ValueError) and not self.rfile.closed:
                raise

    def _solvers(self, query, body, name=None):
        keep = (["identity", "status", "avg_load"] if query.get("filter", "").startswith("none")
                else ["identity", "description", "properties"])
        if name is None:
            return 200, [{key: data[key] for key in keep}
                         for data in self.service.solvers.values()], "solver-definition-list"
        data = self.service.solvers.get(name)
        if data is None:
            return 404, {"error_code": 404, "error_msg": "no such solver"}
        return 200, {key: data[key] for key in keep}, "solver-definition"

    def _begin_upload(self, query, body):
        name = str(uuid.uuid4())
        self.service.uploads[name] = {"size": json.loads(body)["size"], "parts": {}, "whole": None}
        return 200, {"id": name}

    def _put_part(self, query, body, name, number):
        if base64.b64encode(hashlib.md5(body).digest()).decode() != self.headers["Content-MD5"]:
            return 400, {"error_code": 400, "error_msg": "the part is not what its checksum says"}
        if self.service.fault("corrupt", f"part/{number}"):
            body = body[:-1] + bytes([body[-1] ^ 1])
        self.service.uploads[name]["parts"][int(number)] = body
        return 200, {}

    def _upload_status(self, query, body, name):
        upload = self.service.uploads[name]
        return 200, {"status": "UPLOAD_IN_PROGRESS" if upload["whole"] is None
                     else "UPLOAD_COMPLETED", "parts": [{"part_number": number,
                                                         "checksum": hashlib.md5(part).hexdigest()}
                                                        for number,
                                                        part in sorted(upload["parts"].items())]}

    def _combine(self, query, body, name):
        upload = self.service.uploads[name]
        parts = [part for _, part in sorted(upload["parts"].items())]
        digest = hashlib.md5(b"".join(hashlib.md5(part).digest() for part in parts)).hexdigest()
        whole = b"".join(parts)
        if json.loads(body)["checksum"] != digest or len(whole) != upload["size"]:
            return 400, {"error_code": 400, "error_msg": "the parts are not the whole"}
        upload["whole"] = whole
        return 200, {}

    def _submit(self, query, body):
        return 200, [self._create(job) for job in json.loads(body)]

    def _create(self, job):
        data = self.service.solvers.get(job["solver"]["name"])
        low, high = data["properties"].get("num_reads_range", (1, 10**9)) if data else (0, 0)
        if not low <= job["params"].get("num_reads", 1) <= high:
            return {"error_code": 400, "error_msg": f"num_reads must be in range [{low}, {high}]"}
        problem = Problem(self.service, job)
        self.service.problems[problem.id] = problem
        return problem.message(answer=self.service.immediate)

    def _list(self, query, body):
        found = list(self.service.problems.values())
        if "id" in query:
            known = self.service.problems
            found = [known[name].asked() for name in query["id"].split(",") if name in known]
            if "timeout" in query and all(one.status in ("PENDING", "IN_PROGRESS")
                                          for one in found):
                # A client that polls asks again at once; this only spares the machine.
                self.service.closed.wait(0.05)
        if "label" in query:
            found = [problem for problem in found if problem.label == query["label"]]
        return 200, [problem.message() for problem in found]

    def _get(self, query, body, name):
        problem = self.service.problems.get(name)
        if problem is None:
            return 404, {"error_code": 404,
                         "error_msg": "Problem does not exist or apitoken does not have access"}
        return 200, problem.asked().message(answer=True), "problem"

    def _cancel(self, query, body, name):
        problem = self.service.problems[name]
        if problem.status not in ("PENDING", "IN_PROGRESS"):
            return 200, {"error_code": 409, "error_msg": "Problem has been finished."}, "problem"
        problem.cancelled = True
        return 200, problem.message(), "problem"

    def _answer(self, query, body, name):
        return 200, self.service.answers[name]

    ROUTES = [(r"GET solvers/remote/", _solvers), (r"GET solvers/remote/([^/]+)/?", _solvers),
              (r"POST bqm/multipart", _begin_upload), (r"PUT bqm/multipart/([^/]+)/part/(\d+)",
                                                       _put_part),
              (r"GET bqm/multipart/([^/]+)/status", _upload_status),
              (r"POST bqm/multipart/([^/]+)/combine", _combine), (r"POST problems/", _submit),
              (r"GET problems/", _list), (r"GET problems/([^/]+)/?", _get),
              (r"DELETE problems/([^/]+)/?", _cancel), (r"GET answers/([^/]+)", _answer)]
