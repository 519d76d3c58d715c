/// Lists that every rank sends to every other.
#pragma once

#include "petsc/check.hpp"

#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// How many elements come from each rank, if `num_out[r]` go to rank r. Collective.
inline std::vector<int> exchanged_counts(MPI_Comm comm, std::span<const int> num_out) {
  std::vector<int> num_in(num_out.size());
  check_mpi(MPI_Alltoall(num_out.data(), 1, MPI_INT, num_in.data(), 1, MPI_INT, comm));
  return num_in;
}

/// `out`: elements of `width` numbers each, first the `num_out[0]` that go to rank 0, then those to rank 1, ...;
/// `num_in`: exchanged_counts of these. Returns what has come from rank 0, then from rank 1, ... Collective.
template <class T>
requires std::is_trivially_copyable_v<T> std::vector<T> exchanged(MPI_Comm comm, const std::vector<T>& out,
                                                                  std::span<const int> num_out,
                                                                  std::span<const int> num_in, std::size_t width = 1) {
  std::vector<int> out_at(num_out.size()), in_at(num_in.size());
  std::exclusive_scan(num_out.begin(), num_out.end(), out_at.begin(), 0);
  std::exclusive_scan(num_in.begin(), num_in.end(), in_at.begin(), 0);
  std::vector<T> received(width * (static_cast<std::size_t>(in_at.back()) + static_cast<std::size_t>(num_in.back())));
  MPI_Datatype type = MPI_DATATYPE_NULL;
  check_mpi(MPI_Type_contiguous(static_cast<int>(width * sizeof(T)), MPI_BYTE, &type));
  check_mpi(MPI_Type_commit(&type));
  check_mpi(MPI_Alltoallv(out.data(), num_out.data(), out_at.data(), type, received.data(), num_in.data(), in_at.data(),
                          type, comm));
  check_mpi(MPI_Type_free(&type));
  return received;
}

/// `out[r]`: what goes to rank r. Returns what has come from rank 0, then from rank 1, ... Collective.
template <class T>
std::vector<T> exchanged(MPI_Comm comm, const std::vector<std::vector<T>>& out) {
  std::vector<int> num_out;
  std::vector<T> sent;
  for (const std::vector<T>& list : out) {
    num_out.push_back(static_cast<int>(list.size()));
    sent.insert(sent.end(), list.begin(), list.end());
  }
  return exchanged(comm, sent, num_out, exchanged_counts(comm, num_out));
}

/// `questions[r]`: what rank r is asked; `answer` gives what this rank says to one that has come. Returns the answers
/// of rank 0, in the order of its questions, then those of rank 1, ... Collective.
template <class Question, class Answer>
auto answered(MPI_Comm comm, const std::vector<std::vector<Question>>& questions, Answer answer) {
  std::vector<int> num_asked;
  for (const auto& list : questions) num_asked.push_back(static_cast<int>(list.size()));
  const std::vector<int> num_answered = exchanged_counts(comm, num_asked);
  std::vector<std::invoke_result_t<Answer&, const Question&>> answers;
  for (const Question& question : exchanged(comm, questions)) answers.push_back(answer(question));
  return exchanged(comm, answers, num_answered, num_asked);
}

}  // namespace pliant
