#include "tasks/kinds.h"

#include <array>

#include "tasks/bring/bring_task.h"
#include "tasks/clearing/clearing_task.h"
#include "tasks/cylinders/cylinders_task.h"
#include "tasks/demo/demo_task.h"
#include "tasks/grasping/grasping_task.h"
#include "tasks/parts/parts_task.h"
#include "tasks/recognition/recognition_task.h"
#include "tasks/seam/seam_task.h"
#include "tasks/times/times_task.h"

namespace rangegrasp::tasks {

std::span<const experiment::TaskKind> AllKinds() {
  static const std::array kinds = {grasping::GraspingTask(),
                                   clearing::ClearingTask(),
                                   demo::DemoTask(),
                                   bring::BringTask(),
                                   times::TimesTask(),
                                   cylinder_task::CylindersTask(),
                                   seam_task::SeamTask(),
                                   PartsTask(),
                                   recognition_task::RecognitionTask()};
  return kinds;
}

}  // namespace rangegrasp::tasks
