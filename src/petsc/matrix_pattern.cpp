#include "petsc/matrix_pattern.hpp"

#include <utility>

namespace pliant {
namespace {

constexpr const char* name_of_note = "pliant_pattern";

PetscErrorCode destroy_id(void* id) {
  delete static_cast<PetscObjectId*>(id);
  return 0;
}

}  // namespace

bool takes_new_pattern(PetscObject object, Mat matrix) {
  PetscContainer note = nullptr;
  check(PetscObjectQuery(object, name_of_note, reinterpret_cast<PetscObject*>(&note)));
  if (note == nullptr) {
    check(PetscContainerCreate(PetscObjectComm(object), &note));
    check(PetscContainerSetPointer(note, new PetscObjectId(pattern_id(matrix))));
    check(PetscContainerSetUserDestroy(note, destroy_id));
    check(PetscObjectCompose(object, name_of_note, reinterpret_cast<PetscObject>(note)));
    check(PetscContainerDestroy(&note));
    return false;
  }
  void* last = nullptr;
  check(PetscContainerGetPointer(note, &last));
  return std::exchange(*static_cast<PetscObjectId*>(last), pattern_id(matrix)) != pattern_id(matrix);
}

void forget_pattern(PetscObject object) {
  PetscContainer note = nullptr;
  check(PetscObjectQuery(object, name_of_note, reinterpret_cast<PetscObject*>(&note)));
  if (note == nullptr) return;
  void* last = nullptr;
  check(PetscContainerGetPointer(note, &last));
  *static_cast<PetscObjectId*>(last) = 0;  // PETSc numbers objects from 1
}

}  // namespace pliant
