#include "petsc/matrix_pattern.hpp"

#include <utility>

namespace pliant {
namespace {

PetscErrorCode destroy_id(void* id) {
  delete static_cast<PetscObjectId*>(id);
  return 0;
}

}  // namespace

bool takes_new_pattern(PetscObject object, Mat matrix) {
  constexpr const char* name = "pliant_pattern";
  PetscContainer note = nullptr;
  check(PetscObjectQuery(object, name, reinterpret_cast<PetscObject*>(&note)));
  if (note == nullptr) {
    check(PetscContainerCreate(PetscObjectComm(object), &note));
    check(PetscContainerSetPointer(note, new PetscObjectId(pattern_id(matrix))));
    check(PetscContainerSetUserDestroy(note, destroy_id));
    check(PetscObjectCompose(object, name, reinterpret_cast<PetscObject>(note)));
    check(PetscContainerDestroy(&note));
    return false;
  }
  void* last = nullptr;
  check(PetscContainerGetPointer(note, &last));
  return std::exchange(*static_cast<PetscObjectId*>(last), pattern_id(matrix)) != pattern_id(matrix);
}

}  // namespace pliant
