#include "multigrid/halo.hpp"

#include "petsc/exchange.hpp"

#include <algorithm>
#include <utility>

namespace pliant {

Halo::Halo(MPI_Comm comm, int num_owned, std::vector<PetscInt> ghosts)
    : comm_(comm), num_owned_(num_owned), ghosts_(std::move(ghosts)) {
  check(PetscCommGetNewTag(comm, &tag_));
  int num_ranks = 1, rank = 0;
  check_mpi(MPI_Comm_size(comm, &num_ranks));
  check_mpi(MPI_Comm_rank(comm, &rank));
  std::vector<int> counts(at(num_ranks));
  check_mpi(MPI_Allgather(&num_owned, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  begins_.resize(at(num_ranks) + 1);
  for (std::size_t r = 0; r < counts.size(); ++r) begins_[r + 1] = begins_[r] + counts[r];
  first_ = begins_[at(rank)];

  num_of_owner_.resize(at(num_ranks));
  std::vector<std::vector<PetscInt>> asked(at(num_ranks));
  for (const PetscInt node : ghosts_) {
    const int of = owner(node);
    ++num_of_owner_[at(of)];
    asked[at(of)].push_back(node);
  }
  const std::vector<int> num_asked = exchanged_counts(comm, num_of_owner_);
  const std::vector<PetscInt> all = exchanged(comm, asked);
  wanted_.resize(at(num_ranks));
  auto from = all.begin();
  for (std::size_t r = 0; r < wanted_.size(); ++r) {
    for (int k = 0; k < num_asked[r]; ++k) wanted_[r].push_back(static_cast<int>(*from++ - first_));
  }
  num_wanted_ = all.size();
}

int Halo::local(PetscInt node) const {
  if (owns(node)) return static_cast<int>(node - first_);
  return num_owned_ + static_cast<int>(std::ranges::lower_bound(ghosts_, node) - ghosts_.begin());
}

int Halo::owner(PetscInt node) const {
  return static_cast<int>(std::ranges::upper_bound(begins_, node) - begins_.begin()) - 1;
}

namespace {

/// Messages under way; all are complete at the end of the scope.
class Messages {
 public:
  Messages(MPI_Comm comm, int tag) : comm_(comm), tag_(tag) {}
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;
  ~Messages() { (void)MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE); }
  void receive(std::byte* into, std::size_t bytes, std::size_t rank) {
    if (bytes == 0) return;
    check_mpi(MPI_Irecv(into, static_cast<int>(bytes), MPI_BYTE, static_cast<int>(rank), tag_, comm_, next()));
  }
  void send(const std::byte* from, std::size_t bytes, std::size_t rank) {
    if (bytes == 0) return;
    check_mpi(MPI_Isend(from, static_cast<int>(bytes), MPI_BYTE, static_cast<int>(rank), tag_, comm_, next()));
  }

 private:
  MPI_Request* next() { return &requests_.emplace_back(MPI_REQUEST_NULL); }

  MPI_Comm comm_;
  int tag_;
  std::vector<MPI_Request> requests_;
};

}  // namespace

void Halo::send_wanted(const std::byte* packed, std::byte* ghosts, std::size_t bytes) const {
  Messages messages(comm_, tag_);
  for (std::size_t r = 0; r < wanted_.size(); ++r) {
    messages.receive(ghosts, bytes * at(num_of_owner_[r]), r);
    ghosts += bytes * at(num_of_owner_[r]);
  }
  for (std::size_t r = 0; r < wanted_.size(); ++r) {
    messages.send(packed, bytes * wanted_[r].size(), r);
    packed += bytes * wanted_[r].size();
  }
}

void Halo::send_ghosts(const std::byte* ghosts, std::byte* packed, std::size_t bytes) const {
  Messages messages(comm_, tag_);
  for (std::size_t r = 0; r < wanted_.size(); ++r) {
    messages.receive(packed, bytes * wanted_[r].size(), r);
    packed += bytes * wanted_[r].size();
  }
  for (std::size_t r = 0; r < wanted_.size(); ++r) {
    messages.send(ghosts, bytes * at(num_of_owner_[r]), r);
    ghosts += bytes * at(num_of_owner_[r]);
  }
}

}  // namespace pliant
