// Images of particles that give to the nodes.
#include "mpm/modes.hpp"
#include "mpm/policies.hpp"
#include "recon/transfer/scatter.hpp"

namespace recon::mpm {

template <int D>
void ImagePolicy<D>::make(const State<D>& s, const std::vector<Vector<D>>& b,
                          Nodes<D>& nodes) const {
  nodes.images = {};
  if (images_.empty()) return;
  const Particles<D>& from = s.particles;
  nodes.images.of = images_.of(from.x);
  const auto& images = nodes.images.of;
  const Kept kept = this->problem_.kept();
  const std::size_t modes = kept.modes;
  std::vector<std::size_t> of;
  for (const Image<D>& image : images) of.push_back(image.of);
  Particles<D>& to = nodes.images.particles;
  to = chosen(from, kept, of);
  if (!b.empty()) nodes.images.body_force.resize(images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Image<D>& image = images[i];
    // R mirrors places; it has no effect in a translation.
    const Matrix<D> R = Image<D>::signs(image.mirrored).asDiagonal();
    to.x[i] = image.x;
    to.v[i] = image.vector(from.v[image.of]);
    to.F[i] = R * to.F[i] * R;
    to.half_edges[i] = R * to.half_edges[i] * R;  // right-handed as before
    to.L[i] = image.gradient(to.L[i]);
    to.stress[i] = image.gradient(to.stress[i]);
    if (!b.empty()) nodes.images.body_force[i] = image.vector(b[image.of]);
    for (std::size_t a = 0; a < Particles<D>::corner_count && !to.corners.empty(); ++a)
      to.corners[i][a] =
          image.x + image.offset(from.corners[image.of][a ^ image.mirrored] - from.x[image.of]);
    for (std::size_t r = 0; r < modes; ++r) {
      // The slope along an axis; other polynomials have images in periods alone (problem.cpp).
      const unsigned along = image.mirrored == 0 ? 0 : vector_parity(static_cast<int>(r));
      to.modes[i * modes + r] =
          mirror_sign(along, image.mirrored) * image.vector(from.modes[image.of * modes + r]);
    }
  }
}

template <int D>
void ImagePolicy<D>::share(const State<D>& s, Nodes<D>& nodes) const {
  nodes.share.clear();
  if (images_.empty() && s.others == 0) return;
  const Problem<D>& problem = this->problem_;
  const auto mass_of = [&](const Particles<D>& particles, std::size_t begin, std::size_t end) {
    std::vector<double> mass(nodes.mass.size());
    with_shape(problem.method, [&](auto shape_of) {
      using Seen = typename decltype(shape_of)::template Nodes<D>;
      const auto rows = [&](std::size_t p) {
        return shape_of.nodes_along(nodes.grid, particles, begin + p, D - 1);
      };
      scatter_by_rows<Seen>(end - begin, problem.threads, rows, [&](std::size_t p, Seen& shape) {
        shape_of.shape(nodes.grid, particles, begin + p, shape);
        shape.add(mass, particles.mass[begin + p], trusted);
      });
    });
    return mass;
  };
  nodes.share = mass_of(s.particles, 0, s.own());
  std::vector<double> more = mass_of(nodes.images.particles, 0, nodes.images.of.size());
  if (s.others > 0) {
    const std::vector<double> others = mass_of(s.particles, s.own(), s.particles.size());
    for (std::size_t i = 0; i < more.size(); ++i) more[i] += others[i];
  }
  for (std::size_t i = 0; i < more.size(); ++i)
    nodes.share[i] = more[i] == 0 ? 1 : nodes.share[i] / (nodes.share[i] + more[i]);
}

template class ImagePolicy<1>;
template class ImagePolicy<2>;
template class ImagePolicy<3>;

}  // namespace recon::mpm
