/// The file from which a run is resumed: an HDF5 file behind a header of its own.
///
/// bytes 0 .. 511: text "pliant-checkpoint", the version of the format, the size of the file and the CRC-32 of all
/// bytes behind the header, filled up with zeros (HDF5 calls this a user block and passes over it)
///   /              attributes: format "pliant-checkpoint", version, step, time, title, mesh (its fingerprint), ranks,
///                  program, petsc_options
///   /input         the input as understood, a text
///   /state         what was kept (petsc/archive.hpp): numbers as attributes, vectors as datasets named by their paths,
///                  in an order that does not depend on the ranks (petsc/global_order.hpp)
///
/// It is written as `<file>.part`, synced to disk and renamed: the file is complete or absent.
#pragma once

#include "io/hdf5_group.hpp"
#include "petsc/archive.hpp"
#include "petsc/global_order.hpp"
#include "petsc/hdf5.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace pliant {

/// The description in a checkpoint.
struct CheckpointInfo {
  std::int64_t step = 0;      ///< completed steps
  double time = 0.0;          ///< [s]; the load factor in a static problem
  std::string title;          ///< of the run
  std::string input;          ///< YAML
  std::string mesh;           ///< its fingerprint
  std::string program;        ///< version of Pliant
  std::string petsc_options;  ///< of the run that wrote it
  std::int64_t ranks = 1;     ///< likewise
};

/// The orders of everything that vectors may belong to, and the numbers per entry.
struct ArchiveOrders {
  GlobalOrder nodes;
  GlobalOrder internal;
  GlobalOrder pressures;
  int internal_components = 6;

  const GlobalOrder& of(Entries entries) const;
  int components_of(Entries entries) const;
};

/// Collects the state that objects keep, then writes it.
class CheckpointWriter final : public Archive {
 public:
  /// `orders` outlive the object.
  CheckpointWriter(MPI_Comm comm, const ArchiveOrders& orders) : comm_(comm), orders_(orders) {}

  bool restores() const override { return false; }
  /// Replaces the file; after a failure it leaves no trace, and throws FileError on every rank. Collective.
  void write(const std::filesystem::path& file, const CheckpointInfo& info) const;

 private:
  struct Numbers {
    std::string path;
    std::vector<double> values;
  };
  struct Vector {
    std::string path;
    const GlobalOrder* order;
    int components;
    std::vector<double> rows;
  };

  void exchange(const std::string& path, std::span<double> x) override;
  void exchange(const std::string& path, Entries entries, Vec x) override;

  MPI_Comm comm_;
  const ArchiveOrders& orders_;
  std::vector<Numbers> numbers_;
  std::vector<Vector> vectors_;
};

/// Restores the state of objects. FileError on every rank where it is missing in the file.
class CheckpointReader final : public Archive {
 public:
  /// Reads a file that read_checkpoint_info has found intact; `orders` must outlive the object.
  CheckpointReader(MPI_Comm comm, std::filesystem::path file, const ArchiveOrders& orders);

  bool restores() const override { return true; }

 private:
  void exchange(const std::string& path, std::span<double> x) override;
  void exchange(const std::string& path, Entries entries, Vec x) override;

  MPI_Comm comm_;
  std::filesystem::path file_;
  const ArchiveOrders& orders_;
  Hdf5Handle state_;
};

/// Whether the file begins like a checkpoint, intact or not. Not collective.
bool is_checkpoint(const std::filesystem::path& file);

/// Reads the description in a checkpoint after verifying the whole file by its checksum; otherwise throws FileError on
/// every rank, which says what is wrong. Collective.
CheckpointInfo read_checkpoint_info(MPI_Comm comm, const std::filesystem::path& file);

}  // namespace pliant
