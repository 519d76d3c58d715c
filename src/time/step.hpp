/// A requested step in time.
#pragma once

namespace pliant {

/// From the newest accepted state to `time`. The length is given too, so that all nominal steps have the same
/// length to the last bit while their end times n dt carry no accumulated rounding; the two agree to rounding.
struct Step {
  double time = 0.0;           ///< t_{n+1}, the end of the step [s]
  double dt = 0.0;             ///< t_{n+1} - t_n [s]
  bool ends_at_event = false;  ///< functions of time may jump at the end
};

}  // namespace pliant
