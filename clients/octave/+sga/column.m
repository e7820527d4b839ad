function values = column(trajectory, name)
% values = sga.column(result.trajectory, 'x''')   one column of the samples, by its name
  k = find(strcmp(trajectory.columns, name));
  if isempty(k), error('sga:column', 'there is no column %s; there are: %s', name, strjoin(trajectory.columns(:).', ', ')); end
  values = trajectory.rows(:, k);
end
