// _pliant: driven simulations (run/driven_simulation.hpp) as a module of Python, which src/python/pliant/simulation.py
// wraps.
#include "base/error.hpp"
#include "petsc/array_view.hpp"
#include "petsc/blas_kernels.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "run/driven_simulation.hpp"

#include <chrono>
#include <cstring>
#include <dlfcn.h>
#include <memory>
#include <new>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

namespace py = pybind11;
using namespace pliant;
using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Changes = std::vector<std::pair<std::string, std::string>>;

/// Lives until Python ends.
std::unique_ptr<Session> session;

/// Starts MPI and PETSc, unless that is done.
void start() {
  if (session) return;
  // Plugins of Open MPI look its symbols up in the global scope; Python has loaded it for this module alone.
  (void)dlopen("libmpi.so.40", RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);
  session = std::make_unique<Session>("python", std::vector<std::string>{});
}

Rows rows_of(const std::vector<double>& values) {
  Rows rows({static_cast<py::ssize_t>(values.size() / 3), py::ssize_t{3}});
  if (!values.empty()) std::memcpy(rows.mutable_data(), values.data(), values.size() * sizeof(double));
  return rows;
}

std::vector<double> values_of(const Rows& rows) {
  return {rows.data(), rows.data() + rows.size()};
}

std::vector<Override> overrides(const Changes& changes) {
  std::vector<Override> result;
  for (const auto& [path, value] : changes) result.push_back({path, value});
  return result;
}

/// A communicator of its own, so that messages of the program and of Pliant stay apart.
class OwnCommunicator {
 public:
  explicit OwnCommunicator(std::optional<int> handle) {
    const MPI_Comm given = handle ? MPI_Comm_f2c(*handle) : PETSC_COMM_WORLD;
    check_mpi(MPI_Comm_dup(given, &comm_));
  }
  ~OwnCommunicator() { (void)MPI_Comm_free(&comm_); }
  OwnCommunicator(const OwnCommunicator&) = delete;
  OwnCommunicator& operator=(const OwnCommunicator&) = delete;
  MPI_Comm get() const { return comm_; }

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
};

class PythonSimulation {
 public:
  /// `text`: of the input; none: that of the file. `handle`: Fortran's handle of a communicator; none: all ranks.
  PythonSimulation(const std::optional<std::string>& text, const std::string& file, const Changes& changes,
                   std::optional<int> handle, bool writes_files)
      : comm_(std::in_place, handle) {
    const SilentPetsc silent;
    using Files = DrivenInput::Files;
    simulation_.emplace(comm_->get(), DrivenInput{text ? *text : input_text(comm_->get(), file), file,
                                                  overrides(changes), writes_files ? Files::written : Files::none});
  }
  /// Nothing else may be called after it. Collective.
  void close() {
    simulation_.reset();
    comm_.reset();
  }

  int rank() const { return pliant::rank(comm_->get()); }
  double time() const { return simulation_->record().time; }
  double dt() const { return simulation_->record().dt; }
  double next_dt() const { return simulation_->finished() ? 0.0 : simulation_->next_step().dt; }
  std::int64_t step() const { return simulation_->record().step; }
  bool is_finished() const { return simulation_->finished(); }
  double end() const { return simulation_->config().time.end; }
  std::string title() const { return simulation_->config().title; }
  std::string directory() const { return simulation_->config().output.directory; }
  const std::vector<std::string>& columns() const { return simulation_->columns(); }
  py::array_t<double> row() const {
    const std::vector<double>& values = simulation_->row();
    return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
  }
  /// (severity, line): 1 for a warning, 0 for a note.
  std::vector<std::pair<int, std::string>> diagnostics() const {
    std::vector<std::pair<int, std::string>> lines;
    for (const Diagnostic& d : simulation_->model().diagnostics()) {
      lines.emplace_back(d.severity == Severity::warning ? 1 : 0, to_string(d));
    }
    if (simulation_->config().checkpoint) {
      lines.emplace_back(1,
                         "warning: 'checkpoint' has no effect where Python drives the simulation, whose loads a "
                         "checkpoint does not have; Simulation.save keeps states in memory");
    }
    return lines;
  }

  /// The reasons of attempts that were repeated.
  std::vector<std::string> advance() {
    const SilentPetsc silent;
    std::vector<std::string> warnings;
    simulation_->advance([&](const std::string& reason) { warnings.push_back(reason); });
    return warnings;
  }
  void set(const Changes& changes) {
    const SilentPetsc silent;
    simulation_->set(overrides(changes));
  }

  std::vector<std::string> surfaces() const { return simulation_->surfaces(); }
  std::vector<std::int64_t> nodes_on(const std::string& name) const { return simulation_->surface(name).numbers; }
  Rows on_surface(const std::string& name, const std::string& what) const {
    const SilentPetsc silent;
    const DrivenSurface& surface = simulation_->surface(name);
    if (what == "coordinates") return rows_of(simulation_->coordinates_on(surface));
    if (what == "reaction") return rows_of(simulation_->reactions_on(surface));
    return rows_of(simulation_->on_surface(surface, vector(what)));
  }
  void apply_forces(const std::string& name, const Rows& forces) {
    const SilentPetsc silent;
    simulation_->apply_forces(name, values_of(forces));
  }
  void move(const std::string& name, const Rows& displacements) {
    const SilentPetsc silent;
    simulation_->move(name, values_of(displacements));
  }

  /// The rows of all nodes, or of those that this rank owns.
  Rows of_nodes(const std::string& what, bool is_own) const {
    const SilentPetsc silent;
    const NodeLayout& layout = simulation_->model().layout();
    const auto size = 3 * static_cast<std::size_t>(layout.num_owned_nodes);
    std::vector<double> mine(layout.coordinates.begin(),
                             layout.coordinates.begin() + static_cast<std::ptrdiff_t>(size));
    if (what != "coordinates") {
      const ConstArrayView values(vector(what));
      mine.assign(values.span().begin(), values.span().begin() + static_cast<std::ptrdiff_t>(size));
    }
    return rows_of(is_own ? mine : gathered(comm_->get(), mine));
  }
  /// Numbers of the nodes that this rank owns: from and up to.
  std::pair<std::int64_t, std::int64_t> own_nodes() const {
    const NodeLayout& layout = simulation_->model().layout();
    return {layout.first_global_node, layout.first_global_node + layout.num_owned_nodes};
  }

  DrivenSimulation::Saved save() {
    const SilentPetsc silent;
    return simulation_->save();
  }
  void restore(const DrivenSimulation::Saved& saved) {
    const SilentPetsc silent;
    simulation_->restore(saved);
  }
  void write_frame() {
    const SilentPetsc silent;
    simulation_->write_frame();
  }

 private:
  Vec vector(const std::string& what) const {
    const StepRecord& record = simulation_->record();
    return what == "velocity" ? record.v : record.q;
  }

  std::optional<OwnCommunicator> comm_;
  std::optional<DrivenSimulation> simulation_;
};

/// What `save` returns; Python only hands it back.
struct Token {
  DrivenSimulation::Saved state;
};

/// Whether all ranks call this within so many seconds.
bool all_ranks_arrive(double seconds) {
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Ibarrier(PETSC_COMM_WORLD, &request));
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (int done = 0;;) {
    check_mpi(MPI_Test(&request, &done, MPI_STATUS_IGNORE));
    if (done != 0) return true;
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace

PYBIND11_MODULE(_pliant, module) {
  // (exit code of the program, message): the package makes its own exceptions of it.
  static const py::exception<InputError> failure(module, "Failure");
  py::register_exception_translator([](std::exception_ptr thrown) {
    const auto raise = [](ExitCode code, const char* text) {
      PyErr_SetObject(failure.ptr(), py::make_tuple(static_cast<int>(code), text).ptr());
    };
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      raise(ExitCode::input, error.what());
    } catch (const FileError& error) {
      raise(ExitCode::file, error.what());
    } catch (const SolveError& error) {
      raise(ExitCode::solve, error.what());
    } catch (const PetscFailure& error) {
      raise(ExitCode::unexpected, error.what());
    } catch (const std::bad_alloc&) {
      raise(ExitCode::unexpected, "this machine has too little memory; use more machines or a coarser mesh");
    }
  });

  module.def("start", &start);
  module.def("finish", [] { session.reset(); });
  module.def("num_ranks", [] { return pliant::num_ranks(PETSC_COMM_WORLD); });
  module.def("all_ranks_arrive", &all_ranks_arrive);
  module.def("abort", [](int code) { MPI_Abort(PETSC_COMM_WORLD, code); });
  module.def("better_blas_kernels", &better_blas_kernels);

  py::class_<Token>(module, "Token");
  py::class_<PythonSimulation>(module, "Simulation")
      .def(py::init<const std::optional<std::string>&, const std::string&, const Changes&, std::optional<int>, bool>())
      .def_property_readonly("rank", &PythonSimulation::rank)
      .def_property_readonly("time", &PythonSimulation::time)
      .def_property_readonly("dt", &PythonSimulation::dt)
      .def_property_readonly("next_dt", &PythonSimulation::next_dt)
      .def_property_readonly("step", &PythonSimulation::step)
      .def_property_readonly("finished", &PythonSimulation::is_finished)
      .def_property_readonly("end", &PythonSimulation::end)
      .def_property_readonly("title", &PythonSimulation::title)
      .def_property_readonly("directory", &PythonSimulation::directory)
      .def_property_readonly("columns", &PythonSimulation::columns)
      .def_property_readonly("row", &PythonSimulation::row)
      .def_property_readonly("diagnostics", &PythonSimulation::diagnostics)
      .def_property_readonly("surfaces", &PythonSimulation::surfaces)
      .def_property_readonly("own_nodes", &PythonSimulation::own_nodes)
      .def("close", &PythonSimulation::close)
      .def("advance", &PythonSimulation::advance)
      .def("set", &PythonSimulation::set)
      .def("nodes_on", &PythonSimulation::nodes_on)
      .def("on_surface", &PythonSimulation::on_surface)
      .def("apply_forces", &PythonSimulation::apply_forces)
      .def("move", &PythonSimulation::move)
      .def("of_nodes", &PythonSimulation::of_nodes)
      .def("save", [](PythonSimulation& simulation) { return Token{simulation.save()}; })
      .def("restore", [](PythonSimulation& simulation, const Token& token) { simulation.restore(token.state); })
      .def("write_frame", &PythonSimulation::write_frame);
}
