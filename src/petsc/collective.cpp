#include "petsc/collective.hpp"

#include "base/error.hpp"
#include "petsc/check.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <exception>
#include <numeric>
#include <sstream>

namespace pliant {
namespace {

enum class FailureKind : int { none, input, file, other };

struct WorkOutcome {
  FailureKind failure = FailureKind::none;
  std::string text;  // of InputError: one record per diagnostic, fields separated by '\x1f', records by '\x1e'
};

constexpr char field_end = '\x1f';
constexpr char record_end = '\x1e';

/// Removes the separators from a text: names from a user's file may contain anything.
std::string without_separators(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == field_end || c == record_end || c == '\0'; }, ' ');
  return text;
}

std::string packed(const InputError& error) {
  std::string text;
  for (const auto& d : error.diagnostics()) {
    text += without_separators(d.where.file) + field_end + std::to_string(d.where.line) + field_end +
            std::to_string(d.where.column) + field_end + without_separators(d.message) + record_end;
  }
  return text;
}

std::vector<Diagnostic> unpacked(const std::string& text) {
  std::vector<Diagnostic> diagnostics;
  std::istringstream records(text);
  std::string record;
  while (std::getline(records, record, record_end)) {
    std::istringstream fields(record);
    Diagnostic d;
    std::string line, column;
    std::getline(fields, d.where.file, field_end);
    std::getline(fields, line, field_end);
    std::getline(fields, column, field_end);
    std::getline(fields, d.message, '\0');
    d.where.line = std::stoi(line);
    d.where.column = std::stoi(column);
    diagnostics.push_back(d);
  }
  return diagnostics;
}

WorkOutcome outcome_of(const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const InputError& e) {
    return {FailureKind::input, packed(e)};
  } catch (const FileError& e) {
    return {FailureKind::file, e.what()};
  } catch (const std::exception& e) {
    return {FailureKind::other, e.what()};
  }
}

std::string broadcast_from(MPI_Comm comm, std::string text, int root) {
  auto size = static_cast<long long>(text.size());
  check_mpi(MPI_Bcast(&size, 1, MPI_LONG_LONG, root, comm));
  text.resize(static_cast<std::size_t>(size));
  check_mpi(MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, root, comm));
  return text;
}

void throw_everywhere(MPI_Comm comm, WorkOutcome outcome, int from) {
  int kind = static_cast<int>(outcome.failure);
  check_mpi(MPI_Bcast(&kind, 1, MPI_INT, from, comm));
  const auto failure = static_cast<FailureKind>(kind);
  if (failure == FailureKind::none) return;
  const std::string text = broadcast_from(comm, std::move(outcome.text), from);
  switch (failure) {
    case FailureKind::input:
      throw InputError(unpacked(text));
    case FailureKind::file:
      throw FileError(text);
    default:
      throw PetscFailure(PETSC_ERR_LIB, text);
  }
}

template <class T>
T reduced(MPI_Comm comm, T x, MPI_Datatype type, MPI_Op op) {
  T result = x;
  check_mpi(MPI_Allreduce(&x, &result, 1, type, op, comm));
  return result;
}

}  // namespace

void on_root(MPI_Comm comm, const std::function<void()>& work) {
  throw_everywhere(comm, rank(comm) == 0 ? outcome_of(work) : WorkOutcome{}, 0);
}

void on_every_rank(MPI_Comm comm, const std::function<void()>& work) {
  WorkOutcome mine = outcome_of(work);
  const int size = num_ranks(comm);
  const int candidate = mine.failure == FailureKind::none ? size : rank(comm);
  const int first = reduced(comm, candidate, MPI_INT, MPI_MIN);
  if (first < size) throw_everywhere(comm, std::move(mine), first);
}

std::string broadcast(MPI_Comm comm, std::string text) {
  return broadcast_from(comm, std::move(text), 0);
}

double sum(MPI_Comm comm, double x) {
  return reduced(comm, x, MPI_DOUBLE, MPI_SUM);
}
double maximum(MPI_Comm comm, double x) {
  return reduced(comm, x, MPI_DOUBLE, MPI_MAX);
}
double minimum(MPI_Comm comm, double x) {
  return reduced(comm, x, MPI_DOUBLE, MPI_MIN);
}
PetscInt64 sum(MPI_Comm comm, PetscInt64 x) {
  return reduced(comm, x, MPIU_INT64, MPI_SUM);
}

void sum_in_place(MPI_Comm comm, std::span<double> values) {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM, comm));
}
bool any_rank(MPI_Comm comm, bool x) {
  return reduced(comm, static_cast<int>(x), MPI_INT, MPI_MAX) != 0;
}

std::vector<int> counts_of_ranks(MPI_Comm comm, std::size_t mine) {
  const int count = static_cast<int>(mine);
  std::vector<int> counts(static_cast<std::size_t>(num_ranks(comm)));
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  return counts;
}

void gather_rows(MPI_Comm comm, std::size_t row, std::span<const std::byte> mine, std::span<const int> counts,
                 std::span<std::byte> all) {
  std::vector<int> offsets(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, offsets.begin() + 1);
  MPI_Datatype type = MPI_DATATYPE_NULL;
  check_mpi(MPI_Type_contiguous(static_cast<int>(row), MPI_BYTE, &type));
  check_mpi(MPI_Type_commit(&type));
  check_mpi(MPI_Allgatherv(mine.data(), static_cast<int>(mine.size() / row), type, all.data(), counts.data(),
                           offsets.data(), type, comm));
  check_mpi(MPI_Type_free(&type));
}

}  // namespace pliant
