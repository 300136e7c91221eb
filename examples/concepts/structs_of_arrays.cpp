// Your data as they lie: structs of arrays, arrays of structs, flat arrays, Eigen matrices.
//
// A view says where the numbers are and copies none. The same three particles in five layouts, and
// the same answer of each; results go into your own arrays, too.
#include <recon/recon.hpp>

#include <cstdio>

struct Grain {
  int type;
  float age;
  std::array<double, 2> position;
  double momentum[2];
};

int main() {
  const std::vector<double> x{0, 1, 0}, y{0, 0, 1}, px{1, 2, 3}, py{5, 5, 7};
  const std::vector<double> flat{0, 0, 1, 0, 0, 1}, pairs{1, 5, 2, 5, 3, 7};
  const std::vector<Grain> grains{
      {1, 0, {0, 0}, {1, 5}}, {1, 0, {1, 0}, {2, 5}}, {2, 0, {0, 1}, {3, 7}}};
  Eigen::MatrixXd matrix(3, 2), columns(2, 3);
  matrix << 1, 5, 2, 5, 3, 7;
  columns << 0, 1, 0, 0, 0, 1;
  const std::vector<std::array<double, 2>> target{{0.25, 0.5}};

  const auto show = [&](const char* layout, const recon::PointsView<double>& points,
                        const recon::FieldView<double>& momentum) {
    const auto fit =
        recon::reconstruct(points, recon::points_of(target), {.neighbours = recon::Radius{3}});
    double out[1][2] = {};
    fit.apply(momentum, recon::field_of(out));
    std::printf("%-18s %.3f %.3f\n", layout, out[0][0], out[0][1]);
  };
  show("array per axis", recon::points_of(x, y), recon::field_of(px, py));
  show("array of structs", recon::points_of(grains, &Grain::position),
       recon::field_of(grains, &Grain::momentum));
  show("flat array", recon::points_of_flat(flat, 2), recon::field_of_flat(pairs, 2));
  show("row per particle", recon::points_of(x, y), recon::field_of(matrix));
  show("column per point", recon::points_of(columns.transpose()), recon::field_of(matrix));
}

// Output
// array per axis     2.250 6.000
// array of structs   2.250 6.000
// flat array         2.250 6.000
// row per particle   2.250 6.000
// column per point   2.250 6.000
