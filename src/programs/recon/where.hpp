// --where: the particles that count, by a condition on their columns.
//
//   type == 2 and z > 1
//   not (vx^2 + vy^2 < 1 or mass >= 3) and `v [m/s]` > 0
//
// Columns stand by their names, those that are no plain words (letters, digits, _, or an entry such
// as c_stress[1]) in backticks. Numbers, + - * / ^, == != < <= > >=, and, or, not (or && || !),
// parentheses, sqrt, abs, min, max, sin, ... and a ? b : c; `not` and comparisons bind as in words:
// not a == b is not (a == b). A column of the file goes before the constant pi.
//
// Ended with wrong_usage, naming the place: an unknown column (with the nearest names), an
// assignment, comparisons in a row (0 < z < 1 does not mean what it says), a list, anything else
// that is no condition. Ended with wrong_input: a column that holds text or a number that is not
// finite, and a row where the condition is neither true nor false.
#pragma once

#include <string>
#include <vector>

#include "recon/fields/particle_table.hpp"

namespace recon::program {

// One answer per row. Rows without a value in a column of the condition are left out of the table
// before (ParticleTable::leave_out_missing).
std::vector<bool> rows_where(const std::string& condition, ParticleTable& table);

}  // namespace recon::program
