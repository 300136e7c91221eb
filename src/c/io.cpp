#include "c/handles.hpp"
#include "recon/io/read.hpp"

struct recon_table {
  recon::ParticleTable table;
};

using recon::c::there;

recon_status recon_read(const char* path, int frame, recon_table** table) {
  return recon::c::made_by(table, [&] {
    recon::ReadOptions options;
    options.frame = frame;
    return std::make_unique<recon_table>(
        recon_table{recon::read_particles(&there(path, "path"), options)});
  });
}

void recon_table_free(recon_table* table) {
  delete table;
}

size_t recon_table_size(const recon_table* table) {
  return table ? table->table.size() : 0;
}

recon_status recon_table_column(const recon_table* table, const char* name, const double** column) {
  return recon::c::guarded([&] {
    there(column, "column") = nullptr;
    *column = there(table, "table").table.column(&there(name, "name")).data();
  });
}

recon_status recon_table_positions(const recon_table* table, recon_array* positions) {
  return recon::c::guarded([&] {
    const recon::ParticleTable& from = there(table, "table").table;
    const std::vector<std::string> names = from.coordinates();
    std::array<const double*, recon::max_dimension> axes{};
    for (std::size_t d = 0; d < names.size(); ++d) axes[d] = from.column(names[d]).data();
    there(positions, "positions") = recon_double_arrays(axes[0], axes[1], axes[2], from.size());
  });
}
